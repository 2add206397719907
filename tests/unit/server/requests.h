// The usual requests of clients and workers, for a test to change where it wants others.
#pragma once

#include <cstdint>
#include <string>

#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"
#include "wire/digest.h"
#include "wire/version.h"

namespace tessera::server {

/// A square of `side` pixels in tiles of 16 x 16, of the scene that is this one blob; `ranges` of four
/// samples a pixel.
inline v1::JobSpec square_spec(const std::string& scene, std::uint32_t side, std::uint32_t ranges = 1) {
  v1::JobSpec spec;
  spec.mutable_content()->set_scene(wire::sha256_hex(scene));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  spec.mutable_view()->set_width(side);
  spec.mutable_view()->set_height(side);
  spec.mutable_cut()->mutable_crop()->set_x1(side);
  spec.mutable_cut()->mutable_crop()->set_y1(side);
  spec.mutable_cut()->set_tile_size(16);
  spec.mutable_cut()->set_samples_per_unit(4);
  spec.mutable_samples()->set_spp(4 * ranges);
  return spec;
}

/// Registration of a worker of this build with two threads, on a host of its own name.
inline v1::RegisterRequest registration(const std::string& name, const std::string& isa = "avx2") {
  v1::RegisterRequest request;
  request.set_protocol(wire::kProtocolVersion);
  request.set_build(wire::build_version());
  request.set_isa(isa);
  request.add_supported_isas(isa);
  request.add_arithmetic_classes(isa + "/embree-3.13.5/0badcafe");
  request.set_name(name);
  request.set_host(name);
  request.set_threads(2);
  return request;
}

}  // namespace tessera::server
