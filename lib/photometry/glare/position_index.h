// How much less a source dazzles that is off the line of sight.
#pragma once

namespace tessera::photometry {

/// A unit vector as an eye sees it: right, up, and along the line of sight.
struct ViewDirection {
  double right = 0, up = 0, forward = 1;
};

/// Position index of a source: 1 on the line of sight, more beside it, 16 at most. Above the line of sight by
/// Guth's fit [IES2000, CIE117], below it by [Iwata1997], as evalglare has both. Sources behind the eye
/// have 16.
double position_index(const ViewDirection& source);

}  // namespace tessera::photometry
