// Results of a job's phases, ready to be read.
#pragma once

namespace tessera::render {

/// Data that an algorithm reads out of the blobs of its phases: a photon map, a cache, a guiding field. Any
/// number of threads read it at once. It does not outlive the scene.
class Prepared {
 public:
  virtual ~Prepared() = default;
};

}  // namespace tessera::render
