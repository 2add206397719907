// Meshes of a scene: files read once, in parallel.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "import/mitsuba/document/property_reader.h"
#include "wire/mesh_blob.h"

namespace tessera::client::mitsuba {

/// Gathers what is to be read while shapes are converted; then reads all of it.
class MeshTable {
 public:
  explicit MeshTable(Context& context) : context_(context) {}

  /// A shape "obj", "ply" or "serialized", whose message gets its mesh when `load` runs.
  void add_file(PropertyReader& reader, const Imath::M44d& world_from_object, v1::Shape& shape);

  /// A mesh that is made here; normals as they stand.
  void add(const wire::MeshData& mesh, v1::Shape& shape);

  /// Reads the files and completes the shapes. Errors at the shapes' places.
  void load();

 private:
  enum class Format { kObj, kPly, kSerialized };
  struct Job {
    Format format;
    std::filesystem::path path;
    std::int64_t index = 0;  // number of the mesh in a serialized file
    bool flip_v = false;
    bool face_normals = false;
    Imath::M44d placement;  // used for normals that depend on it
    // Results.
    absl::Status status;
    std::string bytes, digest;
    bool has_own_normals = false;
    std::vector<std::string> warnings;
    struct Attribute {
      v1::MeshAttribute message;
      std::string bytes, digest;
    };
    std::vector<Attribute> attributes;
  };
  struct Use {
    v1::Shape* shape;
    std::size_t job;
    bool mirrored;  // world_from_object mirrors it
    SourceLocation where;
  };
  using Key = std::tuple<std::string, std::int64_t, bool, bool, std::array<double, 16>>;

  static void run(Job& job);
  static absl::Status read(Job& job, wire::MeshData& mesh);
  void complete(const Use& use, const Job& job, const v1::TriangleMesh& mesh);

  Context& context_;
  std::vector<Job> jobs_;
  std::map<Key, std::size_t> job_of_key_;
  std::vector<Use> uses_;
};

}  // namespace tessera::client::mitsuba
