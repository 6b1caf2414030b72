"""The physics: one scalar function per equation of Lyashenko & Zaskoka (2013), arXiv:1302.0720.

Equation numbers and symbols come from the paper, the latter in ASCII. Functions take all parameters
`p`, in SI units or in the units of `scaling.py`: the equations are the same in both.
"""
