#!/bin/sed -Ef
# Links to pages that are not among Doxygen's: the path beside the text.
s/\[([^]]*)\]\(([^):]*)\)/\1 (\2)/g
s/!([^()]*) \(([^)]*\.png)\)/![\1](\2)/g
