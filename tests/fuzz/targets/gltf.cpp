#include "fuzz/target.h"
#include "import/import.h"
#include "wire/mesh_blob.h"

namespace tessera::fuzz {

/// A .glb by its first bytes, else a .gltf. Every moment of its animations is as good as another.
const Target kGltf = {"gltf", [](std::string_view bytes) {
                        const char* const name = bytes.starts_with("glTF") ? "scene.glb" : "scene.gltf";
                        client::ImportOptions options;
                        options.threads = 1;
                        options.gltf.time = 0.5;
                        const auto scene = client::import_scene(scratch_file(name, bytes), options);
                        if (!scene.ok()) {
                          require(!scene.status().message().empty(), "an error without a message");
                          return false;
                        }
                        const auto require_sound = [&](const v1::Shape& shape) {
                          for (const client::SceneBlob& blob : scene->blobs) {
                            if (blob.ref.digest() == shape.mesh().blob().digest())
                              require(wire::decode_mesh(blob.bytes).ok(),
                                      "the importer made an unsound mesh");
                          }
                        };
                        for (const v1::Shape& shape : scene->scene.shapes()) require_sound(shape);
                        for (const v1::Object& object : scene->scene.objects()) {
                          for (const v1::Shape& shape : object.shapes()) require_sound(shape);
                        }
                        return true;
                      }};

}  // namespace tessera::fuzz
