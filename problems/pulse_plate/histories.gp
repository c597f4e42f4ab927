# Velocity of the middle and of the free end over time (the paper's figure 13). After running the
# scene and its variants `traditional` and `paper_weights_traditional`:
#   gnuplot -d -c problems/pulse_plate/histories.gp out PICTURE.png
out = ARG1
file(variant) = out.'/pulse_plate'.variant.'/history.csv'
set terminal pngcairo size 1300,520 font 'sans,11'
set output ARG2
set datafile separator ','
set multiplot layout 1,2
set xlabel 'time (ms)'
set ylabel 'velocity (m/s)'
set grid lc rgb '#dddddd'
set key bottom left
set samples 2000
f(t) = t > 0 && t < 2 ? 1 - cos(pi*t) : 0
# x in m, t in ms, c = 2 m/ms: the pulse on its way in, then turned over by the clamp
v(x, t) = f(t - (10 - x)/2.0) - f(t - (10 + x)/2.0) - f(t - (30 - x)/2.0)
set title 'free end'
set xrange [0:13]
set yrange [-4.3:2.9]
plot v(10, x) with lines lw 4 lc rgb '#bbbbbb' title 'bar, closed form', \
  file('') using ($1*1e3):(column('end.velocity.x')) with lines lw 2 lc rgb '#0072b2' title 'dual horizon', \
  file('-traditional') using ($1*1e3):(column('end.velocity.x')) with lines lw 1.5 lc rgb '#d55e00' title 'own horizon only', \
  file('-paper_weights_traditional') using ($1*1e3):(column('end.velocity.x')) with lines lw 1.5 dt 2 lc rgb '#d55e00' title 'own horizon only, paper''s weights'
set title 'middle of the plate'
set xrange [0:9.5]
set yrange [-2.4:2.6]
plot v(5, x) with lines lw 4 lc rgb '#bbbbbb' title 'bar, closed form', \
  file('') using ($1*1e3):(column('middle.velocity.x')) with lines lw 2 lc rgb '#0072b2' title 'dual horizon', \
  file('-traditional') using ($1*1e3):(column('middle.velocity.x')) with lines lw 1.5 lc rgb '#d55e00' title 'own horizon only', \
  file('-paper_weights_traditional') using ($1*1e3):(column('middle.velocity.x')) with lines lw 1.5 dt 2 lc rgb '#d55e00' title 'own horizon only, paper''s weights'
