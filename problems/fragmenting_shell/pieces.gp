# Pieces over the velocity, and how their masses are distributed. After running the scene and its variants:
#   gnuplot -d -c problems/fragmenting_shell/pieces.gp out PICTURE.png
out = ARG1
set terminal pngcairo size 1300,500 font 'sans,11'
set output ARG2
set datafile separator ','
speeds = '25 50 100 200 400'
names(law, v) = law eq '' ? (v == 100 ? '' : sprintf('-v%d', v)) : sprintf('-%s_v%d', law, v)
file(law, v) = out.'/fragmenting_shell'.names(law, v).'/fragments.csv'
array count[10]
do for [l = 1:2] {
  do for [k = 1:5] {
    f = file(word('critical variational', l) eq 'critical' ? '' : 'variational', int(word(speeds, k)))
    stats f using 3 every ::1 nooutput
    mass = STATS_sum
    stats f using ($3 > 0.005*mass ? 1 : 0) every ::1 nooutput
    count[5*(l - 1) + k] = STATS_sum
  }
}
set multiplot layout 1,2
set grid lc rgb '#dddddd'
set logscale xy
set xrange [20:500]
set yrange [4:100]
set xlabel 'velocity (m/s)'
set ylabel 'pieces above 0.5 % of the mass'
set key top left
# rate v/R, piece (24 Gc/(rho rate^2))^(1/3), 2 pi R around
grady(v) = 2*pi*0.1/(24*2e4/(7850*(v/0.1)**2))**(1./3)
plot grady(x) with lines lw 4 lc rgb '#b0b0b0' title 'Grady: velocity^{2/3}', \
  for [l = 1:2] '+' using (real(word(speeds, int($0) + 1))):(count[5*(l - 1) + int($0) + 1]) every ::0::4 \
  with linespoints lw 2 pt 7 lc rgb word('#c0392b #154360', l) title word('critical_stretch variational', l) noenhanced
unset logscale
set logscale xy
set xrange [1e-5:0.3]
set yrange [1:200]
set xlabel "piece's share of the mass"
set ylabel 'pieces at least as heavy'
set key top right
plot for [l = 1:2] for [v in '25 100 400'] file(l == 1 ? '' : 'variational', int(v)) using ($3/0.0861):($0 + 1) every ::1 \
  with lines lw (0.8 + 0.007*int(v)) lc rgb word('#c0392b #154360', l) \
  title word('critical_stretch variational', l).', '.v.' m/s' noenhanced
