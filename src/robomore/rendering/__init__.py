"""Rendering: robots as pictures, videos and windows.

Here belongs whatever turns a model and its poses into something to look at: drawings without
OpenGL, images, video files, an interactive window. It decides nothing and stores nothing.
"""
