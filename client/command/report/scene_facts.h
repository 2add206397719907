// Attributes of an image file that tell of the scene that it shows.
#pragma once

#include "image/image.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Adds the camera's matrices, the names of what numbers in the image stand for, and Cryptomattes, of so many
/// ranks, by names of shapes, materials, and what instances place.
void add_scene_facts(const v1::Scene& scene, const v1::JobSpec& spec, std::uint32_t matte_ranks,
                     Image& image);

/// Makes Cryptomattes of lists that are left, by numbers in place of names: "object 12".
void resolve_nameless_mattes(std::uint32_t matte_ranks, Image& image);

}  // namespace tessera::client
