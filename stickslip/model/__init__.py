"""The physics: one scalar function per equation of Lyashenko & Zaskoka (2013), arXiv:1302.0720.

Equation numbers are the paper's; symbols are the paper's in ASCII. Functions take the parameters
`p` as a whole, in SI units or in those of `scaling.py`; the equations are the same in both.
"""
