// All that stands in the world, one thing after the other, for balances of light.
#pragma once

#include <string>
#include <vector>

#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// A shape of the scene, or an instance with all that its object holds.
struct PlacedThing {
  std::string name;               // unique only where the scene's names are
  std::vector<v1::Shape> shapes;  // in world space, but for borders of media that light just passes
  bool shines = false;            // some shape has light of its own
  std::string obstacle;           // why `shapes` does not hold all; empty: it does
};

/// The scene's shapes, then its instances, in their order. Instances of one object are numbered where there
/// are several. Those that move, hold more than can be read one by one, or are packed have an obstacle.
std::vector<PlacedThing> placed_things(const v1::Scene& scene);

}  // namespace tessera::client
