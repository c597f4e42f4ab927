# Way of the tip, and what it is off from steps of 0.4 ms. After running the scene and its variants:
#   gnuplot -d -c problems/slow_bend/tip.gp out PICTURE.png
out = ARG1
file(variant) = out.'/slow_bend'.variant.'/history.csv'
set terminal pngcairo size 1300,480 font 'sans,11'
set output ARG2
set datafile separator ','
set multiplot layout 1,2
set xlabel 'time (ms)'
set grid lc rgb '#dddddd'
set key bottom left
set ylabel 'tip, upwards (mm)'
plot file('-leapfrog') using ($1*1e3):(column('tip.displacement.y')*1e3) with lines lw 4 lc rgb '#e59866' title 'leapfrog, 653,470 steps', \
  file('') using ($1*1e3):(column('tip.displacement.y')*1e3) with points pt 7 ps 0.6 lc rgb '#154360' title 'energy-momentum, 100 steps'
set ylabel 'kinetic energy (J)'
set logscale y
set format y '10^{%T}'
set key bottom right
plot file('-leapfrog') using ($1*1e3):2 with lines lw 1.5 lc rgb '#e59866' title 'leapfrog', \
  file('-fine') using ($1*1e3):2 with lines lw 1.5 lc rgb '#5dade2' title 'energy-momentum, 1000 steps', \
  file('') using ($1*1e3):2 with lines lw 1.5 lc rgb '#154360' title 'energy-momentum, 100 steps'
