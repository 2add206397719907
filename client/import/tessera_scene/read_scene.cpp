#include "import/tessera_scene/read_scene.h"

#include <algorithm>
#include <limits>
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

/// Notes where the shapes of the field "shapes" of a message stand, and their operands.
template <class Holder>
void note_shapes(const std::string& file, const Holder& holder, Locations& locations,
                 std::unordered_map<const void*, Diagnostic>& places) {
  const auto note = [&](const v1::Shape& shape, Locations& in, const auto* field, int index) {
    const auto at = in.GetLocation(field, index);
    if (at.line < 0) return;
    const std::string name = shape.name().empty() ? "" : concat(" (", shape.name(), ")");
    places[&shape] = {file, static_cast<std::uint32_t>(at.line + 1),
                      static_cast<std::uint32_t>(at.column + 1), concat("shape", name, ": ")};
  };
  const auto* const shapes = Holder::descriptor()->FindFieldByName("shapes");
  const auto* const csg = v1::Shape::descriptor()->FindFieldByName("csg");
  const auto* const parts = v1::Csg::descriptor()->FindFieldByName("parts");
  const auto* const solid = v1::Csg::Part::descriptor()->FindFieldByName("solid");
  for (int i = 0; i < holder.shapes_size(); ++i) {
    const v1::Shape& shape = holder.shapes(i);
    note(shape, locations, shapes, i);
    if (!shape.has_csg()) continue;
    Locations* const of_shape = locations.GetTreeForNested(shapes, i);
    Locations* const of_csg = of_shape == nullptr ? nullptr : of_shape->GetTreeForNested(csg, -1);
    for (int k = 0; of_csg != nullptr && k < shape.csg().parts_size(); ++k) {
      Locations* const of_part = of_csg->GetTreeForNested(parts, k);
      if (of_part != nullptr && shape.csg().parts(k).has_solid())
        note(shape.csg().parts(k).solid(), *of_part, solid, -1);
    }
  }
}

/// Notes where the elements of a repeated field of the scene stand.
template <class Elements>
void note_elements(const std::string& file, const Elements& elements, const char* field, const char* what,
                   Locations& locations, std::unordered_map<const void*, Diagnostic>& places) {
  const auto* const descriptor = v1::Scene::descriptor()->FindFieldByName(field);
  for (int i = 0; i < elements.size(); ++i) {
    const auto at = locations.GetLocation(descriptor, i);
    if (at.line < 0) return;
    const std::string name = elements[i].name().empty() ? "" : concat(" (", elements[i].name(), ")");
    places[&elements[i]] = {file, static_cast<std::uint32_t>(at.line + 1),
                            static_cast<std::uint32_t>(at.column + 1), concat(what, name, ": ")};
  }
}

void note_places(const std::string& file, Locations& locations, ImportedScene& imported) {
  note_shapes(file, imported.scene, locations, imported.places);
  note_elements(file, imported.scene.lights(), "lights", "light", locations, imported.places);
  note_elements(file, imported.scene.materials(), "materials", "material", locations, imported.places);
  const auto camera = locations.GetLocation(v1::Scene::descriptor()->FindFieldByName("camera"), -1);
  if (camera.line >= 0) {
    imported.places[&imported.scene.camera()] = {file, static_cast<std::uint32_t>(camera.line + 1),
                                                 static_cast<std::uint32_t>(camera.column + 1), "camera: "};
  }
  const auto* const objects = v1::Scene::descriptor()->FindFieldByName("objects");
  for (int i = 0; i < imported.scene.objects_size(); ++i) {
    if (Locations* const of_object = locations.GetTreeForNested(objects, i))
      note_shapes(file, imported.scene.objects(i), *of_object, imported.places);
  }
}

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
  pack_instances(scene, blobs);
  if (scene.name().empty()) scene.set_name(path.stem().string());
  ImportedScene imported{std::move(scene), blobs.take(), diagnostics.warnings()};
  if (locations != nullptr) note_places(path.string(), *locations, imported);
  return imported;
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
