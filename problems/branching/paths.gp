# Paths of all tips on lattices turned by 0, 22.5 and 45 degrees under both laws, and the speed of the
# tip that gets farthest (slope over 3 mm). After running the scene and its variants:
#   gnuplot -d -c problems/branching/paths.gp out PICTURE.png
out = ARG1
file(variant) = out.'/branching'.variant.'/cracks.csv'
set terminal pngcairo size 1300,1000 font 'sans,11'
set output ARG2
set datafile separator ','
set grid lc rgb '#dddddd'
array runs[6] = ['', '-turned_22', '-turned_45', '-variational', '-variational_turned_22', '-variational_turned_45']
array names[6] = ['critical stretch, 0 deg', '22.5 deg', '45 deg', 'variational, 0 deg', '22.5 deg', '45 deg']
array colours[6] = ['#0072b2', '#56b4e9', '#009e73', '#d55e00', '#e69f00', '#cc79a7']
set multiplot layout 3,1
set xlabel 'x (mm)'
set ylabel 'y (mm)'
set xrange [48:100]
set yrange [-17:17]
set key outside right
do for [law=0:1] {
  set title law == 0 ? 'paths, critical stretch' : 'paths, variational'
  plot for [k=1+3*law:3+3*law] file(runs[k]) using (1e3*column('x')):(1e3*column('y')) with points pt 7 ps 0.5 lc rgb colours[k] title names[k]
}
set title 'speed of the tip that gets farthest'
set xlabel 'time (us)'
set ylabel 'm/s'
set xrange [5:46]
set yrange [0:3300]
plot for [k=1:6] file(runs[k]) using (column('arm') == 0 ? 1e6*column('time') : 1/0):'smooth_speed' with lines lw 1.5 lc rgb colours[k] title names[k], \
  3102 with lines dt 2 lc rgb 'black' title 'Rayleigh waves'
