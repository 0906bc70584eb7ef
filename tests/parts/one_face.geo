// A C with round ends, swept from one closed spline: a single face lies on both sides of the wall. Lengths in mm.
R = 20; T = 4; W = 24; // mid-line, thickness, width
g = 0.35*Pi;                 // half of the opening
n = 96; m = 16;              // points on a side and on an end

k = 0;
For i In {0:n-1}
  a = g + 2*(Pi - g)*i/n; k += 1;
  Point(k) = {(R + T/2)*Cos(a), (R + T/2)*Sin(a), 0};
EndFor
For i In {0:m-1}
  a = 2*Pi - g; b = a + Pi*i/m; k += 1;
  Point(k) = {R*Cos(a) + T/2*Cos(b), R*Sin(a) + T/2*Sin(b), 0};
EndFor
For i In {0:n-1}
  a = 2*Pi - g - 2*(Pi - g)*i/n; k += 1;
  Point(k) = {(R - T/2)*Cos(a), (R - T/2)*Sin(a), 0};
EndFor
For i In {0:m-1}
  a = g; b = a + Pi + Pi*i/m; k += 1;
  Point(k) = {R*Cos(a) + T/2*Cos(b), R*Sin(a) + T/2*Sin(b), 0};
EndFor
Spline(1) = {1:k, 1};
Curve Loop(1) = {1}; Plane Surface(1) = {1};
Extrude {0, 0, W} { Surface{1}; }
