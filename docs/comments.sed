#!/bin/sed -Ef
# Plain comments as Doxygen reads them: those behind a declaration, on its line, belong to it, the
# others to what follows. Signs that Doxygen would take for commands or HTML are escaped.
/\/\*/!b
:join
/\*\//!{
  N
  b join
}
/^ *\/\* ----/b
# What stands before the comment waits in the hold space.
h
s/^([^/]|\/[^*])*//
s/[<>@#\\]/\\&/g
s/([^.])\.\. \*\//\1, \&hellip; *\//
x
s/\/\*.*//
G
s/\n//
1s/^\/\* /\/** @file\n/
s/^( *)\/\* /\1\/** /
s/^(.*[^ ].*)\/\* /\1\/**< /
