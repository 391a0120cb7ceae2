// Python texts with their words marked, and what changed between two texts.

import { make } from "./words.js";

const TOKEN = new RegExp([
  String.raw`(?<comment>#[^\n]*)`,
  String.raw`(?<string>"""[\s\S]*?"""|'''[\s\S]*?'''|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')`,
  String.raw`(?<keyword>\b(?:False|None|True|and|as|assert|break|class|continue|def|del|elif|else|except|finally|for|from|if|import|in|is|lambda|not|or|pass|raise|return|try|while|with|yield)\b)`,
  String.raw`(?<literal>\b\d[\d_.]*(?:[eE][+-]?\d+)?\b)`,
].join("|"), "g");

// Returns spans of a text; everything in it stays text.
export function highlighted(text) {
  const parts = [];
  let done = 0;
  for (const match of text.matchAll(TOKEN)) {
    const [kind] = Object.entries(match.groups).find(([, found]) => found !== undefined);
    parts.push(text.slice(done, match.index), make("span", { class: kind }, match[0]));
    done = match.index + match[0].length;
  }
  return [...parts, text.slice(done)];
}

// Returns [[mark, line]] with the marks " ", "-" and "+": a longest common subsequence of lines.
export function difference(before, after) {
  const [a, b] = [before.trimEnd().split("\n"), after.trimEnd().split("\n")];
  const length = Array.from({ length: a.length + 1 }, () => new Uint16Array(b.length + 1));
  for (let i = a.length - 1; i >= 0; i--) {
    for (let j = b.length - 1; j >= 0; j--) {
      length[i][j] = a[i] === b[j] ? length[i + 1][j + 1] + 1
        : Math.max(length[i + 1][j], length[i][j + 1]);
    }
  }
  const found = [];
  let [i, j] = [0, 0];
  while (i < a.length || j < b.length) {
    if (i < a.length && j < b.length && a[i] === b[j]) {
      found.push([" ", a[i]]);
      i++;
      j++;
    } else if (j === b.length || (i < a.length && length[i + 1][j] >= length[i][j + 1])) {
      found.push(["-", a[i++]]);
    } else {
      found.push(["+", b[j++]]);
    }
  }
  return found;
}

export function differenceBlock(before, after) {
  const names = { "-": "removed", "+": "added", " ": "" };
  return make("pre", { tabindex: "0", class: "difference" }, ...difference(before, after)
    .map(([mark, line]) => make("span", { class: names[mark] }, `${mark} ${line}\n`)));
}

export function sourceBlock(text) {
  return make("pre", { tabindex: "0" }, ...highlighted(text));
}
