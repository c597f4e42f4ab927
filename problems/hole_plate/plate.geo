// A plate, 200 mm x 200 mm, with a hole of 5 mm radius in its middle; finer at the hole.
// The mesh: gmsh -2 plate.geo -o plate.msh
r = 5; w = 100; // in mm: the scene says so (unit: 1 mm)
fine = 0.5; coarse = 8;
Point(1) = {-w, -w, 0, coarse};
Point(2) = {w, -w, 0, coarse};
Point(3) = {w, w, 0, coarse};
Point(4) = {-w, w, 0, coarse};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Point(5) = {0, 0, 0, fine};
Point(6) = {r, 0, 0, fine};
Point(7) = {0, r, 0, fine};
Point(8) = {-r, 0, 0, fine};
Point(9) = {0, -r, 0, fine};
Circle(5) = {6, 5, 7};
Circle(6) = {7, 5, 8};
Circle(7) = {8, 5, 9};
Circle(8) = {9, 5, 6};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {5, 6, 7, 8};
// A disc about the hole has a name of its own, so that materials, measures and cracks can use it.
inner = 15; between = 1.2;
Point(10) = {inner, 0, 0, between};
Point(11) = {0, inner, 0, between};
Point(12) = {-inner, 0, 0, between};
Point(13) = {0, -inner, 0, between};
Circle(9) = {10, 5, 11};
Circle(10) = {11, 5, 12};
Circle(11) = {12, 5, 13};
Circle(12) = {13, 5, 10};
Curve Loop(3) = {9, 10, 11, 12};
Plane Surface(1) = {1, 3};
Plane Surface(2) = {3, 2};
Physical Curve("hole") = {5, 6, 7, 8};
Physical Curve("left") = {4};
Physical Curve("right") = {2};
Physical Surface("outside") = {1};
Physical Surface("around_hole") = {2};
