#include "import/mitsuba/shapes/meshes.h"

#include <set>
#include <utility>

#include "import/geometry/vertex_normals.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/input/parallel.h"
#include "import/mitsuba/shapes/serialized_mesh.h"
#include "import/obj/obj_reader.h"
#include "import/ply/ply_reader.h"
#include "wire/digest.h"

namespace tessera::client::mitsuba {

void MeshTable::add_file(PropertyReader& reader, const Imath::M44d& world_from_object, v1::Shape& shape) {
  const std::string& type = reader.object().type;
  Job job;
  job.format = type == "obj" ? Format::kObj : type == "ply" ? Format::kPly : Format::kSerialized;
  // Only OBJ files are taken to have their v upside down.
  job.flip_v = reader.boolean("flip_tex_coords", job.format == Format::kObj);
  job.face_normals = reader.boolean("face_normals", false);
  if (job.format == Format::kSerialized) job.index = reader.integer("shape_index", 0);
  const std::optional<std::filesystem::path> path = reader.file("filename");
  if (!path) return;
  job.path = *path;
  // Normals that have to be computed are computed in the world, where a stretched mesh has other angles.
  if (!job.face_normals && !keeps_angles(world_from_object)) {
    job.placement = world_from_object;
    for (int a = 0; a < 3; ++a) job.placement[3][a] = 0;
  }
  const Key key = {path->string(), job.index, job.flip_v, job.face_normals, elements_of(job.placement)};
  const auto [entry, is_new] = job_of_key_.try_emplace(key, jobs_.size());
  if (is_new) jobs_.push_back(std::move(job));
  uses_.push_back(
      {&shape, entry->second, determinant3(world_from_object) < 0, reader.find("filename")->where});
}

void MeshTable::add(const wire::MeshData& mesh, v1::Shape& shape) {
  *shape.mutable_mesh()->mutable_blob() = context_.blobs.add_bytes(wire::encode_mesh(mesh));
}

absl::Status MeshTable::read(Job& job, wire::MeshData& mesh) {
  absl::StatusOr<InputFile> file = InputFile::open(job.path);
  if (!file.ok()) return file.status();
  const auto located = [&](const absl::Status& status) {
    return absl::InvalidArgumentError(concat(job.path.string(), ": ", std::string(status.message())));
  };
  if (job.format == Format::kObj) {
    absl::StatusOr<ObjMesh> obj = read_obj(file->bytes());
    if (!obj.ok()) return located(obj.status());
    mesh = std::move(obj->mesh);
    job.warnings = std::move(obj->warnings);
  } else if (job.format == Format::kPly) {
    absl::StatusOr<PlyMesh> ply = read_ply(file->bytes(), true);
    if (!ply.ok()) return located(ply.status());
    mesh = std::move(ply->mesh);
    job.warnings = std::move(ply->warnings);
    for (const PlyAttribute& attribute : ply->attributes) {
      Job::Attribute& result = job.attributes.emplace_back();
      result.message.set_name(attribute.name);
      result.message.set_channels(attribute.channels);
      result.message.set_per_face(attribute.per_face);
      result.bytes.assign(reinterpret_cast<const char*>(attribute.values.data()),
                          attribute.values.size() * sizeof(float));
      result.digest = wire::sha256_hex(result.bytes);
    }
  } else {
    absl::StatusOr<SerializedMesh> serialized = read_serialized_mesh(file->bytes(), job.index);
    if (!serialized.ok()) return located(serialized.status());
    mesh = std::move(serialized->mesh);
    job.face_normals = job.face_normals || serialized->face_normals;
  }
  return absl::OkStatus();
}

void MeshTable::run(Job& job) {
  wire::MeshData mesh;
  job.status = read(job, mesh);
  if (!job.status.ok()) return;
  if (job.flip_v) {
    for (std::size_t i = 1; i < mesh.uvs.size(); i += 2) mesh.uvs[i] = 1 - mesh.uvs[i];
  }
  job.has_own_normals = !job.face_normals && !mesh.normals.empty();
  if (job.face_normals) {
    mesh.normals.clear();
  } else if (mesh.normals.empty()) {
    compute_vertex_normals(mesh, job.placement);
  }
  job.bytes = wire::encode_mesh(mesh);
  job.digest = wire::sha256_hex(job.bytes);
}

void MeshTable::complete(const Use& use, const Job& job, const v1::TriangleMesh& mesh) {
  v1::Shape& shape = *use.shape;
  *shape.mutable_mesh() = mesh;
  if (!use.mirrored) return;
  // Mitsuba takes the geometric normal from the vertices in the world, where mirroring has turned it over;
  // here it is that of the mesh, or on the side of the mesh's own normals.
  if (job.has_own_normals) {
    shape.mutable_interior_medium()->swap(*shape.mutable_exterior_medium());
  } else {
    shape.set_reverse_orientation(!shape.reverse_orientation());
  }
}

void MeshTable::load() {
  parallel_for(jobs_.size(), context_.threads, [&](std::size_t i) { run(jobs_[i]); });
  std::vector<v1::TriangleMesh> meshes(jobs_.size());
  for (std::size_t i = 0; i < jobs_.size(); ++i) {
    Job& job = jobs_[i];
    if (!job.status.ok()) continue;
    *meshes[i].mutable_blob() = context_.blobs.add_bytes(std::move(job.bytes), job.digest);
    for (Job::Attribute& attribute : job.attributes) {
      *attribute.message.mutable_blob() =
          context_.blobs.add_bytes(std::move(attribute.bytes), attribute.digest);
      *meshes[i].add_attributes() = attribute.message;
    }
  }
  std::set<std::size_t> reported;
  for (const Use& use : uses_) {
    const Job& job = jobs_[use.job];
    if (job.status.ok()) complete(use, job, meshes[use.job]);
    if (!reported.insert(use.job).second) continue;
    if (!job.status.ok()) context_.diagnostics.error(use.where, std::string(job.status.message()));
    for (const std::string& warning : job.warnings) {
      context_.diagnostics.warning(use.where, concat(job.path.filename().string(), ": ", warning));
    }
  }
}

}  // namespace tessera::client::mitsuba
