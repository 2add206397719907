#include "command/gltf_choice.h"

#include "command/read_option.h"

namespace tessera::client {

void define_gltf_options(options::Command& command, GltfOptions& gltf) {
  constexpr double kLongest = 1e9, kBrightest = 1e9;
  command.group("glTF scenes");
  command.add("--camera", gltf.camera, "the camera, by its name or number").type_name("NAME");
  command.add("--time", gltf.time, "the moment of its animations, in seconds").in_range(0, kLongest);
  command.add("--shutter", gltf.shutter, "seconds for which the shutter is open while they move")
      .in_range(0, kLongest);
  const WordList<ShutterPosition> positions = {{"start", ShutterPosition::kStart},
                                               {"center", ShutterPosition::kCenter},
                                               {"end", ShutterPosition::kEnd}};
  add_choice(command, "--shutter-position", positions, gltf.shutter_position,
             "where the moment is in that time: start, center or end");
  command.add("--animation", gltf.animation, "only this animation, by its name or number").type_name("NAME");
  command.add("--variant", gltf.variant, "the variant of its materials, by its name or number")
      .type_name("NAME");
  command
      .add("--default-light", gltf.default_light,
           "where the file has no light, a white sky of this radiance overhead")
      .in_range(0, kBrightest);
}

}  // namespace tessera::client
