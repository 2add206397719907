// Parameters that several kinds of textures have in common, into a node.
#pragma once

#include "absl/status/status.h"
#include "render/color/texture_table.h"
#include "render/scene/placement/render_space.h"
#include "spectra/color/rgb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

TextureNode constant_node(const spectra::Rgb& value);

absl::Status set_mapping(const v1::UvMapping& mapping, const RenderSpace& space, TextureNode& node);
absl::Status set_noise(const v1::NoiseTexture& noise, const RenderSpace& space, TextureNode& node);
absl::Status set_direction(const v1::Point3& world, const RenderSpace& space, TextureNode& node);

/// Replaces a node of `table` whose inputs are constants by its value.
void fold(const TextureTable& table, TextureNode& node);

}  // namespace tessera::render
