"""A reward is a program by a stranger: how it is checked, loaded and kept from doing harm.

`check` reads the text and says what is wrong in words that a designer can act on; it is hygiene.
`contain` runs a function in a process of its own that can reach no file but its scratch folder, no
network, no other process and no key; that boundary is the promise. `load` turns the text into a
function and is only ever called inside such a process. `layers` says what this machine offers.
"""
