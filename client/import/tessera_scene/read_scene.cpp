#include "import/tessera_scene/read_scene.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>

#include "absl/strings/str_join.h"
#include "google/protobuf/io/tokenizer.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "import/input/blob_collector.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/input/instance_list.h"
#include "import/ply/ply_reader.h"
#include "import/tessera_scene/blob_refs.h"
#include "import/tessera_scene/check_scene.h"
#include "wire/enum_words.h"
#include "wire/mesh_blob.h"
#include "wire/packed_instances.h"
#include "wire/scene_numbers.h"

namespace tessera::client::tessera_scene {
namespace {

/// Messages within one another in a text; of serialized ones protobuf takes as many.
constexpr int kMostLevels = 100;

/// protobuf's message about a value of one of the settings' enums, with what it leaves out: the names that
/// there are, or the one that stands for the word given as a string (which settings were once).
std::string with_names(const std::string& message) {
  const google::protobuf::Descriptor& settings = *v1::RenderSettings::descriptor();
  std::vector<std::string> names;
  for (int i = 0; i < settings.field_count(); ++i) {
    const wire::EnumType* const type = settings.field(i)->enum_type();
    if (type == nullptr) continue;
    const bool unknown = message.ends_with(concat("for field \"", settings.field(i)->name(), "\"."));
    for (const std::string& word : wire::words_of(*type)) {
      const int number = wire::number_of(*type, word, "").value();
      const bool meant = message.ends_with(concat("got: \"", word, "\""));
      if (unknown || meant) names.push_back(type->FindValueByNumber(number)->name());
    }
  }
  return names.empty() ? message : concat(message, " There is: ", absl::StrJoin(names, ", "));
}

/// protobuf counts lines and columns from 0.
class ErrorCollector : public google::protobuf::io::ErrorCollector {
 public:
  ErrorCollector(Diagnostics& diagnostics, std::uint32_t file) : diagnostics_(diagnostics), file_(file) {}

  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    diagnostics_.error(location(line, column), with_names(message));
  }
  void AddWarning(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    diagnostics_.warning(location(line, column), message);
  }

 private:
  SourceLocation location(int line, int column) const {
    return {file_, static_cast<std::uint32_t>(line + 1), static_cast<std::uint32_t>(column + 1)};
  }

  Diagnostics& diagnostics_;
  std::uint32_t file_;
};

/// Finds the bytes of one reference, and completes it.
class BlobResolver {
 public:
  BlobResolver(std::filesystem::path directory, BlobCollector& blobs, Diagnostics& diagnostics)
      : directory_(std::move(directory)), blobs_(blobs), diagnostics_(diagnostics) {}

  absl::Status resolve(v1::BlobRef& ref, bool is_mesh, SourceLocation where) {
    if (ref.path().empty()) {
      return absl::InvalidArgumentError("expected \"path\": a scene file names each blob by its file");
    }
    const std::filesystem::path path = directory_ / ref.path();
    const bool is_ply = is_mesh && (path.extension() == ".ply" || path.string().ends_with(".ply.gz"));
    absl::StatusOr<v1::BlobRef> found = is_ply ? convert_ply(path, where) : blobs_.add_file(path, ref.path());
    if (!found.ok()) return found.status();
    if (is_mesh && !is_ply) {
      if (absl::Status status = check_mesh(path); !status.ok()) return status;
    }
    if (!ref.digest().empty() && ref.digest() != found->digest()) {
      return absl::InvalidArgumentError(concat(path.string(), ": its digest is ", found->digest(), ", not ",
                                               ref.digest(), " as the scene says"));
    }
    ref.set_digest(found->digest());
    ref.set_size_bytes(found->size_bytes());
    return absl::OkStatus();
  }

 private:
  absl::StatusOr<v1::BlobRef> convert_ply(const std::filesystem::path& path, SourceLocation where) {
    absl::StatusOr<InputFile> file = InputFile::open(path);
    if (!file.ok()) return file.status();
    absl::StatusOr<PlyMesh> ply = read_ply(file->bytes());
    if (!ply.ok()) return absl::InvalidArgumentError(concat(path.string(), ": ", ply.status().message()));
    for (const std::string& warning : ply->warnings) {
      diagnostics_.warning(where, concat(path.string(), ": ", warning));
    }
    return blobs_.add_bytes(wire::encode_mesh(ply->mesh));
  }

  static absl::Status check_mesh(const std::filesystem::path& path) {
    absl::StatusOr<InputFile> file = InputFile::open(path);
    if (!file.ok()) return file.status();
    const absl::StatusOr<wire::MeshView> mesh = wire::decode_mesh(file->bytes());
    return mesh.ok() ? absl::OkStatus()
                     : absl::InvalidArgumentError(concat(path.string(), ": ", mesh.status().message()));
  }

  std::filesystem::path directory_;
  BlobCollector& blobs_;
  Diagnostics& diagnostics_;
};

/// The place of a number, as near as the parser recorded it; line 0 without locations.
SourceLocation place_of(const wire::BadNumber& number, std::uint32_t file, Locations* locations) {
  google::protobuf::TextFormat::ParseLocation place{-1, -1};
  for (std::size_t i = 0; i < number.path.size() && locations != nullptr; ++i) {
    const auto& [field, index] = number.path[i];
    const auto location = locations->GetLocation(field, index);
    if (location.line >= 0) place = location;
    const bool is_message = field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE;
    locations = is_message ? locations->GetTreeForNested(field, index) : nullptr;
  }
  return {file, static_cast<std::uint32_t>(place.line + 1), static_cast<std::uint32_t>(place.column + 1)};
}

using Places = std::unordered_map<const void*, Diagnostic>;
using FieldPlaces = std::map<std::pair<const void*, int>, Diagnostic>;

/// Notes the places of elements in one file.
class PlaceNotes {
 public:
  PlaceNotes(const std::string& file, Places& places, FieldPlaces& field_places)
      : file_(file), places_(places), field_places_(field_places) {}

  void note_scene(const v1::Scene& scene, Locations& locations) {
    note_shapes(scene, locations);
    note_all(scene, locations, "lights", "light", scene.lights());
    note_all(scene, locations, "materials", "material", scene.materials());
    note_all(scene, locations, "textures", "texture", scene.textures());
    note_all(scene, locations, "media", "medium", scene.media());
    note_camera(scene.camera(), field<v1::Scene>("camera"), -1, locations, "camera: ");
    for (int i = 0; i < scene.views_size(); ++i)
      note_camera(scene.views(i), field<v1::Scene>("views"), i, locations,
                  concat("view ", std::to_string(i + 1), ": "));
    note(scene.rig(), field<v1::Scene>("rig"), -1, locations, "");  // messages name it themselves
    note(scene.film(), field<v1::Scene>("film"), -1, locations, "film: ");
    note_instances(scene, locations);
    for (int i = 0; i < scene.objects_size(); ++i) {
      const auto* const objects = field<v1::Scene>("objects");
      note(scene.objects(i), objects, i, locations, "");  // messages name the object themselves
      Locations* const of_object = locations.GetTreeForNested(objects, i);
      if (of_object == nullptr) continue;
      note_shapes(scene.objects(i), *of_object);
      note_instances(scene.objects(i), *of_object);
    }
  }

 private:
  using Field = google::protobuf::FieldDescriptor;

  template <class Message>
  static const Field* field(const char* name) {
    return Message::descriptor()->FindFieldByName(name);
  }

  static std::string title_of(const char* what, const std::string& name) {
    return name.empty() ? concat(what, ": ") : concat(what, " (", name, "): ");
  }

  void note(const google::protobuf::Message& element, const Field* of, int index, Locations& locations,
            std::string title) {
    const auto at = locations.GetLocation(of, index);
    if (at.line < 0) return;
    places_[&element] = {file_, static_cast<std::uint32_t>(at.line + 1),
                         static_cast<std::uint32_t>(at.column + 1), std::move(title)};
  }

  void note_camera(const v1::Camera& camera, const Field* of, int index, Locations& locations,
                   const std::string& title) {
    note(camera, of, index, locations, title);
    if (Locations* const of_camera = locations.GetTreeForNested(of, index); of_camera != nullptr)
      note_fields(camera, *of_camera, title);
  }

  /// Notes all fields of a message, and of those in it.
  void note_fields(const google::protobuf::Message& message, Locations& locations, const std::string& title) {
    const google::protobuf::Reflection& reflection = *message.GetReflection();
    std::vector<const Field*> fields;
    reflection.ListFields(message, &fields);
    for (const Field* const of : fields) {
      const int count = of->is_repeated() ? reflection.FieldSize(message, of) : 1;
      for (int i = 0; i < count; ++i) {
        const int index = of->is_repeated() ? i : -1;
        if (of->cpp_type() != Field::CPPTYPE_MESSAGE) {
          const auto at = locations.GetLocation(of, index);
          if (at.line >= 0 && i == 0)
            field_places_[{&message, of->number()}] = {file_, static_cast<std::uint32_t>(at.line + 1),
                                                       static_cast<std::uint32_t>(at.column + 1), title};
          continue;
        }
        const google::protobuf::Message& child = of->is_repeated()
                                                     ? reflection.GetRepeatedMessage(message, of, i)
                                                     : reflection.GetMessage(message, of);
        note(child, of, index, locations, title);
        if (Locations* const of_child = locations.GetTreeForNested(of, index); of_child != nullptr)
          note_fields(child, *of_child, title);
      }
    }
  }

  /// Notes the elements of a repeated field.
  template <class Holder, class Elements>
  void note_all(const Holder&, Locations& locations, const char* name, const char* what,
                const Elements& elements) {
    for (int i = 0; i < elements.size(); ++i)
      note(elements[i], field<Holder>(name), i, locations, title_of(what, elements[i].name()));
  }

  /// Notes the shapes of the scene or of an object, and their operands.
  template <class Holder>
  void note_shapes(const Holder& holder, Locations& locations) {
    note_all(holder, locations, "shapes", "shape", holder.shapes());
    for (int i = 0; i < holder.shapes_size(); ++i) {
      const v1::Shape& shape = holder.shapes(i);
      if (!shape.has_csg()) continue;
      Locations* const of_shape = locations.GetTreeForNested(field<Holder>("shapes"), i);
      Locations* const of_csg =
          of_shape == nullptr ? nullptr : of_shape->GetTreeForNested(field<v1::Shape>("csg"), -1);
      for (int k = 0; of_csg != nullptr && k < shape.csg().parts_size(); ++k) {
        Locations* const of_part = of_csg->GetTreeForNested(field<v1::Csg>("parts"), k);
        if (of_part == nullptr || !shape.csg().parts(k).has_solid()) continue;
        const v1::Shape& solid = shape.csg().parts(k).solid();
        note(solid, field<v1::Csg::Part>("solid"), -1, *of_part, title_of("shape", solid.name()));
      }
    }
  }

  /// Notes instances where they stay messages (pack_instances()).
  template <class Holder>
  void note_instances(const Holder& holder, Locations& locations) {
    if (holder.instances_size() > static_cast<int>(InstanceList::kMostMessages)) return;
    for (int i = 0; i < holder.instances_size(); ++i) {
      const v1::Instance& instance = holder.instances(i);
      note(instance, field<Holder>("instances"), i, locations, title_of("instance", instance.object()));
    }
  }

  const std::string& file_;
  Places& places_;
  FieldPlaces& field_places_;
};

absl::Status check_packed(const v1::PackedInstances& packed, const std::filesystem::path& directory) {
  const std::filesystem::path path = directory / packed.matrices().path();
  absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  const auto matrices = wire::decode_matrices(packed, file->bytes());
  return matrices.ok() ? absl::OkStatus()
                       : absl::InvalidArgumentError(concat(path.string(), ": ", matrices.status().message()));
}

/// Checks packed instances, whose blobs are known.
void check_packed_instances(const v1::Scene& scene, const std::filesystem::path& directory,
                            std::uint32_t file, Diagnostics& diagnostics) {
  const auto check = [&](const auto& holder) {
    if (!holder.has_packed_instances()) return;
    if (absl::Status status = check_packed(holder.packed_instances(), directory); !status.ok())
      diagnostics.error({file, 0, 0}, std::string(status.message()));
  };
  check(scene);
  std::ranges::for_each(scene.objects(), check);
}

absl::StatusOr<ImportedScene> resolve_all(v1::Scene scene, const std::filesystem::path& path,
                                          std::uint32_t file, Locations* locations,
                                          Diagnostics& diagnostics) {
  for (const wire::BadNumber& bad : wire::find_bad_numbers(scene, Diagnostics::kMaxErrors)) {
    diagnostics.error(place_of(bad, file, locations), bad.to_string());
  }
  check_scene(scene, file, locations, diagnostics);
  BlobCollector blobs;
  BlobResolver resolver(path.parent_path(), blobs, diagnostics);
  for_each_blob_ref(scene, locations, [&](v1::BlobRef& ref, bool is_mesh, int line) {
    const SourceLocation where{file, static_cast<std::uint32_t>(line), 0};
    if (diagnostics.full()) return;
    if (absl::Status status = resolver.resolve(ref, is_mesh, where); !status.ok()) {
      diagnostics.error(where, std::string(status.message()));
    }
  });
  if (!diagnostics.has_errors()) check_packed_instances(scene, path.parent_path(), file, diagnostics);
  if (absl::Status status = diagnostics.status(); !status.ok()) return status;
  Places places;
  FieldPlaces field_places;
  const std::string name = path.string();
  if (locations != nullptr) PlaceNotes(name, places, field_places).note_scene(scene, *locations);
  pack_instances(scene, blobs);
  if (scene.name().empty()) scene.set_name(path.stem().string());
  return ImportedScene{std::move(scene), blobs.take(), diagnostics.warnings(), std::move(places),
                       std::move(field_places)};
}

}  // namespace

absl::StatusOr<ImportedScene> read_text_scene(const std::filesystem::path& path) {
  absl::StatusOr<InputFile> input = InputFile::open(path);
  if (!input.ok()) return input.status();
  const std::string_view bytes = input->bytes();
  if (bytes.size() > std::numeric_limits<int>::max()) {
    return absl::InvalidArgumentError(concat(path.string(), ": larger than 2 GiB"));
  }
  Diagnostics diagnostics;
  const std::uint32_t file = diagnostics.add_file(path.string());
  ErrorCollector errors(diagnostics, file);
  Locations locations;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&errors);
  parser.WriteLocationsTo(&locations);
  parser.SetRecursionLimit(kMostLevels);
  v1::Scene scene;
  google::protobuf::io::ArrayInputStream stream(bytes.data(), static_cast<int>(bytes.size()));
  if (!parser.Parse(&stream, &scene) && !diagnostics.has_errors()) {
    diagnostics.error({file, 0, 0}, "not a Scene in protobuf text format");
  }
  if (absl::Status status = diagnostics.status(); !status.ok()) return status;
  return resolve_all(std::move(scene), path, file, &locations, diagnostics);
}

absl::StatusOr<ImportedScene> read_binary_scene(const std::filesystem::path& path) {
  absl::StatusOr<InputFile> input = InputFile::open(path);
  if (!input.ok()) return input.status();
  const std::string_view bytes = input->bytes();
  v1::Scene scene;
  if (bytes.size() > std::numeric_limits<int>::max() ||
      !scene.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return absl::InvalidArgumentError(concat(path.string(), ": not a serialized Scene"));
  }
  Diagnostics diagnostics;
  const std::uint32_t file = diagnostics.add_file(path.string());
  if (const v1::RenderSettings& settings = scene.settings();
      !settings.GetReflection()->GetUnknownFields(settings).empty()) {
    diagnostics.warning({file, 0, 0}, "another version wrote this file: some of its settings are left out");
  }
  return resolve_all(std::move(scene), path, file, nullptr, diagnostics);
}

}  // namespace tessera::client::tessera_scene
