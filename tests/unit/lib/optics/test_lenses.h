// Lenses of several tests, and surfaces to write others with.
#pragma once

#include "optics/prescription.h"

namespace tessera::optics {

inline Surface surface(double radius, double thickness, double index, double diameter) {
  Surface s;
  s.radius = radius, s.thickness = thickness, s.diameter = diameter;
  s.behind.index = index;
  return s;
}
inline Surface stop(double thickness, double diameter) {
  Surface s = surface(0, thickness, 1, diameter);
  s.stop = true;
  return s;
}

/// US patent 3,552,829, example 1: focal length 50.
inline Prescription double_gauss() {
  return {
      "double Gauss",
      "",
      {surface(56.655, 5.24, 1.815, 38.5), surface(600, 0.565, 1, 38.5), surface(25.68, 6.56, 1.694, 33.5),
       surface(51.875, 0.8, 1, 28.716), surface(84.6, 2.255, 1.63003, 34), surface(17.295, 5.865, 1, 24.5),
       stop(5.565, 24.1), surface(-19.475, 2.855, 1.7918, 24), surface(246.02, 6.185, 1.8004, 31),
       surface(-35.965, 0.095, 1, 31), surface(-125.895, 4.05, 1.8004, 31.5),
       surface(-37.625, 0.095, 1, 31.5), surface(198.13, 4.05, 1.71615, 31.5), surface(-63.025, 0, 1, 31.5)}};
}

}  // namespace tessera::optics
