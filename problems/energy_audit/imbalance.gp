# What the ledger leaves over, over steps: gnuplot -d -c problems/energy_audit/imbalance.gp RUNS OUT.png
# RUNS holds the directories energy_audit, energy_audit-tenth, and so on.
set terminal pngcairo size 1000,640 font "sans,11"
set output ARG2
set datafile separator ","
set logscale y
set format y "10^{%T}"
set yrange [1e-17:1]
set xrange [0:1000]
set xlabel "step"
set ylabel "|energy - start - external work| / largest energy so far"
set key below maxrows 3
set grid ytics lc rgb "#dddddd"
most = 0
# columns: 2 kinetic, 3 stored, 4 dissipated, 9 imbalance
relative(k, s, d, i) = (e = k + s + d, most = e > most ? e : most, abs(i) > 0 ? abs(i)/most : NaN)
file(name) = ARG1."/energy_audit".name."/history.csv"
set title "A bursting ring: imbalance of energy, dissipated included"
plot most = 0, file("-leapfrog") using ($0*5):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#c0392b" title "leapfrog, 0.9 of its limit", \
     most = 0, file("-leapfrog_tenth") using ($0*5):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#e59866" title "leapfrog, 0.1", \
     most = 0, file("-tenth") using ($0*5):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#aed6f1" title "energy-momentum, 0.1", \
     most = 0, file("-one") using ($0*5):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#5dade2" title "energy-momentum, 1", \
     most = 0, file("") using ($0*5):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#2471a3" title "energy-momentum, 5", \
     most = 0, file("-fifty") using ($0*1):(relative($2, $3, $4, $9)) with lines lw 1.5 lc rgb "#154360" title "energy-momentum, 50", \
     1e-9 with lines dt 2 lc rgb "#888888" title "accepted"
