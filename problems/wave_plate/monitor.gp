# Displacement and velocity along x of the monitor points A and B over time in models A, B and C (the
# paper's figure 10). After running the scene and its variants A and B:
#   gnuplot -d -c problems/wave_plate/monitor.gp out PICTURE.png
out = ARG1
file(variant) = out.'/wave_plate'.variant.'/history.csv'
set terminal pngcairo size 1300,900 font 'sans,11'
set output ARG2
set datafile separator ','
set multiplot layout 2,2
set xlabel 'time (s)'
set grid lc rgb '#dddddd'
set samples 2000
set xrange [0:0.5]
image(x) = exp(-(x/0.01)**2)
u(x, t) = 0.1*(sum [n=-3:3] (image(x - t - 0.2*n) + image(x + t - 0.2*n))) # mm
slope(x) = 2e4*x*image(x)
v(x, t) = 0.1*(sum [n=-3:3] (slope(x - t - 0.2*n) - slope(x + t - 0.2*n))) # mm/s
array places[2] = [0.0255, 0.05025]
array names[2] = ['A', 'B']
do for [k=1:2] {
  set title sprintf('displacement of point %s, x = %.4g mm', names[k], 1e3*places[k])
  set ylabel 'u_x (mm)'
  set yrange [-0.15:0.3]
  name = names[k].'.displacement.x'
  plot [t=0:0.5] u(places[k], t) with lines lw 5 lc rgb '#bbbbbb' title 'exact', \
    file('-B') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#d55e00' title 'B, no dual horizon', \
    file('-A') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#e69f00' title 'A, uniform', \
    file('') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#0072b2' title 'C, dual horizon'
  set title sprintf('velocity of point %s', names[k])
  set ylabel 'v_x (mm/s)'
  set yrange [-18:18]
  name = names[k].'.velocity.x'
  plot [t=0:0.5] v(places[k], t) with lines lw 5 lc rgb '#bbbbbb' title 'exact', \
    file('-B') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#d55e00' title 'B, no dual horizon', \
    file('-A') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#e69f00' title 'A, uniform', \
    file('') using 1:(1e3*column(name)) with lines lw 1.5 lc rgb '#0072b2' title 'C, dual horizon'
}
