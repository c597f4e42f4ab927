# Paths of both tips and the speed of the upper one (slope over 12.5 mm). After running the scene and the
# variants named below:
#   gnuplot -d -c problems/kalthoff_winkler/paths.gp out PICTURE.png
out = ARG1
file(variant) = out.'/kalthoff_winkler'.variant.'/cracks.csv'
set terminal pngcairo size 1300,560 font 'sans,11'
set output ARG2
set datafile separator ','
set grid lc rgb '#dddddd'
array runs[6] = ['', '-graded', '-fine', '-iso', '-variational', '-variational_iso']
array names[6] = ['critical stretch', 'one corner graded', '0.78 mm', 'iso weights', 'variational', 'variational, iso']
array colours[6] = ['#0072b2', '#009e73', '#56b4e9', '#000000', '#d55e00', '#e69f00']
set multiplot layout 1,2
set title 'paths'
set xlabel 'x (mm)'
set ylabel 'y (mm)'
set xrange [0:100]
set yrange [-100:100]
set size ratio -1
unset key
set arrow 1 from 0,25 to 50,25 nohead lw 3 lc rgb '#888888'
set arrow 2 from 0,-25 to 50,-25 nohead lw 3 lc rgb '#888888'
plot for [k=1:6] file(runs[k]) using (1e3*column('x')):(1e3*column('y')) with points pt 7 ps 0.4 lc rgb colours[k]
unset arrow
set size noratio
set key top left
set title 'speed of the upper tip'
set xlabel 'time (us)'
set ylabel 'm/s'
set xrange [20:96]
set yrange [0:3600]
plot for [k=1:6] file(runs[k]) using (strcol(1) eq 'upper' && column('arm') == 0 ? 1e6*column('time') : 1/0):'smooth_speed' with lines lw 1.5 lc rgb colours[k] title names[k], \
  2871.8 with lines dt 2 lc rgb 'black' title 'Rayleigh waves'
