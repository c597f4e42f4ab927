# Displacements along the axes less those of finite elements (the paper's figures 8 to 18). After
# running the scene and its variants:
#   gnuplot -d -c problems/tension_plate/axes.gp problems/tension_plate out PICTURE.png
here = ARG1
out = ARG2
data(variant, name) = sprintf("< awk -v name=%s -f %s/axes.awk %s/%s.csv %s/tension_plate%s/history.csv", \
  name, here, here, name, out, variant)
set terminal pngcairo size 1400,900 font 'sans,11'
set output ARG3
set multiplot layout 2,2
set grid lc rgb '#dddddd'
set key outside right
array colour[5] = ['#999999', '#56b4e9', '#0072b2', '#d55e00', '#009e73']
array model[2] = ['ordinary', 'nonordinary']
array names[2] = ['u', 'v']
array first[2] = [2, 1] # ordinary, n = 1 is a mechanism
array equal[2] = ['30', '20']
do for [m=1:2] { do for [a=1:2] {
  name = names[a]
  file(n) = data(m == 1 && n == 3 ? '' : sprintf('-%s_%d', model[m], n), name)
  set title sprintf('%s: %s along %s', model[m], name, a == 1 ? 'x, y = 0' : 'y, x = 0')
  set xlabel a == 1 ? 'x (m)' : 'y (m)'
  set ylabel sprintf('%s less finite elements (um)', name)
  plot for [n=first[m]:5] file(n) using 1:($3*1e6) with linespoints pt 7 ps 0.6 lw 1.5 lc rgb colour[n] \
      title sprintf('n = %d', n), \
    data(sprintf('-%s_equal', model[m]), name) using 1:($3*1e6) with lines dt 2 lw 1.5 lc rgb '#000000' \
      title sprintf('%s mm everywhere', equal[m])
} }
