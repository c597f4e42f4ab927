# Displacements of the point at (0.255, 0.255) m over time beside those of finite elements (the
# paper's figures 22 to 32). After running the scene and its variants:
#   gnuplot -d -c problems/plate_vibration/histories.gp problems/plate_vibration out PICTURE.png
table = ARG1.'/history.csv'
out = ARG2
file(variant) = out.'/plate_vibration'.variant.'/history.csv'
set terminal pngcairo size 1400,900 font 'sans,11'
set output ARG3
set datafile separator ','
set multiplot layout 2,2
set grid lc rgb '#dddddd'
set key outside right
set xlabel 'time (ms)'
set xrange [0:1]
array colour[5] = ['#999999', '#56b4e9', '#0072b2', '#d55e00', '#009e73']
array model[2] = ['ordinary', 'nonordinary']
array names[2] = ['u', 'v']
array parts[2] = ['x', 'y']
do for [m=1:2] { do for [a=1:2] {
  run(n) = m == 1 && n == 3 ? file('') : file(sprintf('-%s_%d', model[m], n))
  set title sprintf('%s: %s', model[m], names[a])
  set ylabel sprintf('%s (mm)', names[a])
  part = 'point.displacement.'.parts[a]
  plot table using (column('t')*1e3):(column(names[a])*1e3) with lines lw 4 lc rgb '#bbbbbb' title 'finite elements', \
    for [n=1:5] run(n) using ($1*1e3):(column(part)*1e3) with lines lw 1.2 lc rgb colour[n] title sprintf('n = %d', n), \
    file('-'.model[m].'_case_2') using ($1*1e3):(column(part)*1e3) with lines dt 2 lw 1.2 lc rgb '#000000' title 'case 2'
} }
