# Displacement of the point at 0.4995 m over time and its error (the paper's figures 8 and 9). After
# running the scene and its variants `zero` and `uncorrected`:
#   gnuplot -d -c problems/bar_vibration/histories.gp out PICTURE.png
out = ARG1
file(variant) = out.'/bar_vibration'.variant.'/history.csv'
set terminal pngcairo size 1300,520 font 'sans,11'
set output ARG2
set datafile separator ','
set multiplot layout 1,2
set xlabel 'time (ms)'
set grid lc rgb '#dddddd'
set samples 2000
c = sqrt(200e9/7850)/1e3   # m/ms
u(x, t) = 1/pi*(asin(sin(pi/2*(x - c*t))) + asin(sin(pi/2*(x + c*t)))) # mm
name = 'particle_500.displacement.x'
place = 0.4995
set title 'displacement of the middle'
set ylabel 'u (mm)'
set xrange [0:4]
set yrange [-0.6:0.85]
set key top right
plot [t=0:4] u(place, t) with lines lw 5 lc rgb '#bbbbbb' title 'closed form', \
  file('-uncorrected') using ($1*1e3):(1e3*column(name)) with lines lw 1.5 lc rgb '#d55e00' title 'nothing corrected', \
  file('') using ($1*1e3):(1e3*column(name)) with lines lw 1.5 lc rgb '#0072b2' title 'corrected, mirror'
set title 'error of the middle'
set ylabel '|u - closed form| (mm)'
set logscale y
set format y '%.0e'
set yrange [1e-6:100]
plot file('-uncorrected') using ($1*1e3):(abs(1e3*column(name) - u(place, $1*1e3))) with lines lw 1 lc rgb '#d55e00' title 'nothing corrected', \
  file('-zero') using ($1*1e3):(abs(1e3*column(name) - u(place, $1*1e3))) with lines lw 1 lc rgb '#e69f00' title 'corrected, u = 0', \
  file('') using ($1*1e3):(abs(1e3*column(name) - u(place, $1*1e3))) with lines lw 1 lc rgb '#0072b2' title 'corrected, mirror', \
  0.01 with lines dt 2 lw 1.5 lc rgb '#444444' title 'the paper''s corrected error'
