# Energies of the bars over time; grey: exactly. After running the scene and its variant cradle:
#   gnuplot -d -c problems/collision/energies.gp out PICTURE.png
out = ARG1
file(variant) = out.'/collision'.variant.'/history.csv'
set terminal pngcairo size 1300,480 font 'sans,11'
set output ARG2
set datafile separator ','
set multiplot layout 1,2
set xlabel 'time (us)'
set ylabel 'energy (kJ)'
set grid lc rgb '#dddddd'
set yrange [0:21]
set key at graph 0.98, 0.62 right
# Both bars are at half the speed where the wave has come, and strained.
meet(t) = t < 20 ? 20 - t/2 : t < 40 ? t/2 : 20
set title 'two equal bars'
plot [0:60] meet(x) with lines lw 6 lc rgb '#c8c8c8' notitle, 20 - meet(x) with lines lw 6 lc rgb '#c8c8c8' notitle, \
  file('') using ($1*1e6):($2*1e-3) with lines lw 2 lc rgb '#154360' title 'kinetic', \
  file('') using ($1*1e6):($3*1e-3) with lines lw 2 lc rgb '#c0392b' title 'stored', \
  file('') using ($1*1e6):($6*1e-2) with lines lw 1.5 lc rgb '#239b56' title '10 times contact'
# The wave runs on, 200 mm long, until its echo from the end comes back to the cut.
set title 'striker, bar, piece behind a cut'
pass(t) = t < 20 ? 20 - t/2 : t < 50 ? 10 : t < 70 ? 10 + (t - 50)/2 : 20
plot [0:110] pass(x) with lines lw 6 lc rgb '#c8c8c8' notitle, 20 - pass(x) with lines lw 6 lc rgb '#c8c8c8' notitle, \
  file('-cradle') using ($1*1e6):($2*1e-3) with lines lw 2 lc rgb '#154360' title 'kinetic', \
  file('-cradle') using ($1*1e6):($3*1e-3) with lines lw 2 lc rgb '#c0392b' title 'stored', \
  file('-cradle') using ($1*1e6):($6*1e-2) with lines lw 1.5 lc rgb '#239b56' title '10 times contact'
