// Cameras, images, and what nodes say of their meshes.
#include <algorithm>

#include "images/image_blob.h"
#include "import/gltf/file/container.h"
#include "import/gltf/rules/rules.h"

namespace tessera::client::gltf {
namespace object_rules {

void check_camera(Context& context, const Json& camera, const std::string& place) {
  const std::string type = text_of(&camera, "type");
  for (const char* kind : {"perspective", "orthographic"}) {
    const Json* shape = member(&camera, kind);
    if ((shape != nullptr) != (type == kind)) {
      context.error(place, shape != nullptr
                               ? concat("a camera of the type ", type, " with \"", kind, "\"")
                               : concat("a camera of the type ", type, " without \"", kind, "\""));
      continue;
    }
    const Json* znear = member(shape, "znear");
    const Json* zfar = member(shape, "zfar");
    if (znear != nullptr && zfar != nullptr && zfar->get<double>() <= znear->get<double>())
      context.error(below(below(place, kind), "zfar"),
                    concat("zfar is ", zfar->get<double>(), ", not beyond znear, ", znear->get<double>()));
  }
}

/// The type of an image by its first bytes; empty for others.
std::string type_of(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return "image/webp";
  return "";
}

/// Whether the file ends as its format does, without decoding it: it was not cut off.
bool is_whole(std::string_view bytes, std::string_view type) {
  constexpr std::size_t kChunk = 12;
  if (type == "image/png") return bytes.size() > kChunk && bytes.find("IEND") != std::string_view::npos;
  if (type == "image/jpeg") return bytes.rfind("\xff\xd9") != std::string_view::npos;
  return true;
}

class ImageCheck {
 public:
  ImageCheck(Context& context, BufferTable& buffers, AccessorUses& uses)
      : context_(context), buffers_(buffers), uses_(uses) {}

  void check(std::size_t index) {
    const Json& image = *element(&context_.document, "images", index);
    const std::string place = below("/images", index);
    const Json* uri = member(&image, "uri");
    const auto view = index_of(&image, "bufferView");
    if ((uri != nullptr) == view.has_value()) {
      context_.error(place, "an image has either a uri or a bufferView");
      return;
    }
    if (view) {
      if (member(&image, "mimeType") == nullptr)
        context_.error(place, "\"mimeType\" is missing, which an image in a bufferView needs");
      uses_.add_other(*view, below(place, "bufferView"));
      if (const auto bytes = buffers_.view(*view)) check_bytes(*bytes, image, place);
      return;
    }
    const auto& text = uri->get_ref<const std::string&>();
    if (is_data_uri(text)) {
      const absl::StatusOr<std::string> bytes = decode_data_uri(text);
      if (bytes.ok()) {
        check_bytes(*bytes, image, place);
      } else {
        context_.error(below(place, "uri"), std::string(bytes.status().message()));
      }
      return;
    }
    const absl::StatusOr<std::filesystem::path> path = file_of_uri(context_.folder, text);
    const absl::StatusOr<InputFile> file = path.ok() ? open_regular(*path) : path.status();
    if (file.ok()) {
      check_bytes(file->bytes(), image, place);
    } else {
      context_.error(below(place, "uri"), std::string(file.status().message()));
    }
  }

 private:
  /// Formats of extensions that are not read are not looked into: nothing may show them.
  void check_bytes(std::string_view bytes, const Json& image, const std::string& place) {
    const std::string type = type_of(bytes), said = text_of(&image, "mimeType", type);
    if (type.empty()) return;
    const bool is_nickname = said == "image/jpg" && type == "image/jpeg";
    if (said != type && !is_nickname)
      context_.error(below(place, "mimeType"), concat("it says ", said, ", but the image is ", type));
    if (const auto size = images::image_size(bytes, place); !size.ok()) {
      context_.error(place, std::string(size.status().message()));
    } else if (!is_whole(bytes, type)) {
      context_.error(place, concat("the ", type, " is cut off"));
    }
  }

  Context& context_;
  BufferTable& buffers_;
  AccessorUses& uses_;
};

/// Without any image, nothing that is known here shows the texture.
void check_texture(Context& context, const Json& texture, const std::string& place) {
  const std::size_t images = size_of(&context.document, "images");
  const auto check = [&](const Json* object, const std::string& at) {
    const auto source = index_of(object, "source");
    if (source && *source >= images && images > 0)
      context.error(below(at, "source"),
                    concat("expected an index of one of ", images, " images, found ", *source));
  };
  check(&texture, place);
  for (const char* name : {"EXT_texture_webp", "KHR_texture_basisu"})
    check(extension(&texture, name), below(below(place, "extensions"), name));
}

void check_node(Context& context, const Json& node, const std::string& place) {
  const auto mesh = index_of(&node, "mesh");
  const Json* primitives = member(mesh ? element(&context.document, "meshes", *mesh) : nullptr, "primitives");
  if (const std::size_t weights = size_of(&node, "weights")) {
    const std::size_t targets = primitives == nullptr ? 0 : size_of(&primitives->front(), "targets");
    if (!mesh) {
      context.error(below(place, "weights"), "weights of morph targets, but no mesh");
    } else if (weights != targets) {
      context.error(below(place, "weights"), concat(weights, " weights of ", targets, " morph targets"));
    }
  }
  if (!index_of(&node, "skin")) return;
  if (primitives == nullptr) {
    context.error(below(place, "skin"), "a skin, but no mesh");
    return;
  }
  const bool is_skinned = std::ranges::any_of(*primitives, [](const Json& primitive) {
    return index_of(member(&primitive, "attributes"), "JOINTS_0").has_value();
  });
  if (!is_skinned)
    context.error(below(place, "skin"), concat("mesh ", *mesh, " has no JOINTS_0 that it could bend"));
}

}  // namespace object_rules

void check_objects(Context& context, BufferTable& buffers, AccessorUses& uses) {
  using namespace object_rules;
  const auto each = [&](const char* array, auto&& check) {
    for (std::size_t i = 0; i < size_of(&context.document, array) && !context.diagnostics.full(); ++i)
      check(i, *element(&context.document, array, i), below(concat("/", array), i));
  };
  each("cameras",
       [&](std::size_t, const Json& json, const std::string& place) { check_camera(context, json, place); });
  each("accessors", [&](std::size_t, const Json& json, const std::string& place) {
    for (const char* part : {"indices", "values"}) {
      const std::string at = below(below(below(place, "sparse"), part), "bufferView");
      if (const auto view = index_of(member(member(&json, "sparse"), part), "bufferView"))
        uses.add_other(*view, at);
    }
  });
  ImageCheck images(context, buffers, uses);
  each("images", [&](std::size_t i, const Json&, const std::string&) { images.check(i); });
  each("textures",
       [&](std::size_t, const Json& json, const std::string& place) { check_texture(context, json, place); });
  each("nodes",
       [&](std::size_t, const Json& json, const std::string& place) { check_node(context, json, place); });
}

}  // namespace tessera::client::gltf
