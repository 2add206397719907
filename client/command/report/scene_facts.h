// Facts that image files tell of the scene that they show: attributes, and names in Cryptomattes.
#pragma once

#include <cstdint>
#include <vector>

#include "image/cryptomatte.h"
#include "image/image.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Adds facts of the camera, which is one of the scene's, and of the film's exposure; and the names of what
/// numbers in the image stand for.
void add_scene_facts(const v1::Scene& scene, const v1::Camera& camera, const v1::JobSpec& spec, Image& image);

/// Cryptomattes, of so many ranks, by names of shapes, materials, and what instances place. The scene must
/// outlive them.
std::vector<MatteList> mattes_of(const v1::Scene& scene, std::uint32_t ranks);

/// The same where the scene is not there: by numbers in place of names, "object 12".
std::vector<MatteList> nameless_mattes(std::uint32_t ranks);

}  // namespace tessera::client
