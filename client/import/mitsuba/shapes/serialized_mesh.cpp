#include "import/mitsuba/shapes/serialized_mesh.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "import/input/concat.h"
#include "import/input/load_bytes.h"

namespace tessera::client::mitsuba {
namespace {

static_assert(std::endian::native == std::endian::little, "values are read in place");

constexpr std::uint16_t kMagic = 0x041C;
enum Flags : std::uint32_t {
  kNormals = 0x0001,
  kUvs = 0x0002,
  kColors = 0x0008,
  kFaceNormals = 0x0010,
  kDouble = 0x2000,
};
constexpr std::uint64_t kMaxElements = std::uint64_t{1} << 31;  // limit of a mesh blob
// Upper bound of what one mesh inflates to: guards against a few kilobytes that claim to be everything.
constexpr std::size_t kMaxInflatedBytes = std::size_t{8} << 30;

absl::Status fail(const std::string& message) { return absl::InvalidArgumentError(message); }

/// The values of one mesh, inflated piece by piece as they are asked for.
class Inflater {
 public:
  explicit Inflater(std::string_view compressed) : rest_(compressed) {
    ready_ = inflateInit(&stream_) == Z_OK;
  }
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// False where the data end or are damaged.
  bool read(void* to, std::size_t size) {
    if (!ready_ || size > kMaxInflatedBytes - read_) return false;
    auto* out = static_cast<Bytef*>(to);
    while (size > 0) {
      if (stream_.avail_in == 0) {
        const std::size_t take = std::min(rest_.size(), std::size_t{1} << 30);
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
        stream_.avail_in = static_cast<uInt>(take);
        rest_.remove_prefix(take);
      }
      const auto piece = static_cast<uInt>(std::min(size, std::size_t{1} << 30));
      stream_.next_out = out;
      stream_.avail_out = piece;
      const int state = inflate(&stream_, Z_NO_FLUSH);
      const std::size_t got = piece - stream_.avail_out;
      out += got;
      size -= got;
      read_ += got;
      if (size == 0) return true;
      if (state != Z_OK || (got == 0 && stream_.avail_in == 0 && rest_.empty())) return false;
    }
    return true;
  }
  template <typename T>
  bool read(T& value) {
    return read(&value, sizeof(T));
  }

  /// `count` values as floats, in pieces, so that memory grows only with what is really there.
  bool read_floats(std::uint64_t count, bool doubles, std::vector<float>& values) {
    constexpr std::uint64_t kPiece = 1 << 16;
    std::vector<double> wide;
    for (std::uint64_t done = 0; done < count;) {
      const std::uint64_t take = std::min(kPiece, count - done);
      values.resize(done + take);
      if (doubles) {
        wide.resize(take);
        if (!read(wide.data(), take * sizeof(double))) return false;
        for (std::uint64_t i = 0; i < take; ++i) values[done + i] = static_cast<float>(wide[i]);
      } else if (!read(values.data() + done, take * sizeof(float))) {
        return false;
      }
      done += take;
    }
    return true;
  }
  bool read_indices(std::uint64_t count, std::vector<std::uint32_t>& indices) {
    constexpr std::uint64_t kPiece = 1 << 16;
    for (std::uint64_t done = 0; done < count;) {
      const std::uint64_t take = std::min(kPiece, count - done);
      indices.resize(done + take);
      if (!read(indices.data() + done, take * sizeof(std::uint32_t))) return false;
      done += take;
    }
    return true;
  }

 private:
  z_stream stream_{};
  std::string_view rest_;
  bool ready_ = false;
  std::size_t read_ = 0;
};

/// Where mesh `index` begins, by the table at the end of the file.
absl::StatusOr<std::size_t> find_mesh(std::string_view bytes, int version, std::int64_t index) {
  if (index == 0) return 0;
  if (bytes.size() < sizeof(std::uint32_t)) return fail("the file is cut off");
  const std::uint32_t count = load_bytes<std::uint32_t>(bytes, bytes.size() - sizeof(std::uint32_t));
  if (index < 0 || index >= count)
    return fail(concat("there is no mesh ", index, ": the file holds ", count));
  const std::size_t entry = version == 4 ? sizeof(std::uint64_t) : sizeof(std::uint32_t);
  const std::size_t from_end = sizeof(std::uint32_t) + entry * (count - static_cast<std::size_t>(index));
  if (from_end > bytes.size()) return fail("the table of meshes is cut off");
  const std::size_t at = bytes.size() - from_end;
  const std::uint64_t offset =
      version == 4 ? load_bytes<std::uint64_t>(bytes, at) : load_bytes<std::uint32_t>(bytes, at);
  if (offset > bytes.size() - sizeof(std::uint32_t))
    return fail("the table of meshes points outside of the file");
  return static_cast<std::size_t>(offset);
}

bool all_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

absl::StatusOr<SerializedMesh> read_stream(Inflater& stream, int version) {
  constexpr char kCutOff[] = "the mesh is damaged or cut off";
  std::uint32_t flags = 0;
  if (!stream.read(flags)) return fail(kCutOff);
  if (version == 4) {
    char c = 1;
    while (c != 0) {
      if (!stream.read(c)) return fail(kCutOff);
    }
  }
  std::uint64_t vertices = 0, triangles = 0;
  if (!stream.read(vertices) || !stream.read(triangles)) return fail(kCutOff);
  if (vertices > kMaxElements || triangles > kMaxElements) {
    return fail(concat(vertices, " vertices and ", triangles, " triangles: there may be 2^31 of each"));
  }
  const bool doubles = (flags & kDouble) != 0;
  SerializedMesh result;
  wire::MeshData& mesh = result.mesh;
  result.face_normals = (flags & kFaceNormals) != 0;
  std::vector<float> colors;
  const bool whole = stream.read_floats(3 * vertices, doubles, mesh.positions) &&
                     ((flags & kNormals) == 0 || stream.read_floats(3 * vertices, doubles, mesh.normals)) &&
                     ((flags & kUvs) == 0 || stream.read_floats(2 * vertices, doubles, mesh.uvs)) &&
                     ((flags & kColors) == 0 || stream.read_floats(3 * vertices, doubles, colors)) &&
                     stream.read_indices(3 * triangles, mesh.indices);
  if (!whole) return fail(kCutOff);
  for (const std::vector<float>* values : {&mesh.positions, &mesh.normals, &mesh.uvs}) {
    if (!all_finite(*values)) return fail("a coordinate is not finite");
  }
  const auto bad =
      std::find_if(mesh.indices.begin(), mesh.indices.end(), [&](std::uint32_t i) { return i >= vertices; });
  if (bad != mesh.indices.end()) {
    return fail(concat("vertex index ", *bad, " is out of range: there are ", vertices, " vertices"));
  }
  return result;
}

}  // namespace

absl::StatusOr<SerializedMesh> read_serialized_mesh(std::string_view bytes, std::int64_t index) {
  if (bytes.size() < 4 || load_bytes<std::uint16_t>(bytes, 0) != kMagic) return fail("not a serialized mesh");
  const int version = load_bytes<std::uint16_t>(bytes, 2);
  if (version != 3 && version != 4) return fail(concat("format version ", version, ": expected 3 or 4"));
  const absl::StatusOr<std::size_t> offset = find_mesh(bytes, version, index);
  if (!offset.ok()) return offset.status();
  constexpr std::size_t kHeaderBytes = 4;  // repeated before every mesh
  Inflater stream(bytes.substr(std::min(*offset + kHeaderBytes, bytes.size())));
  return read_stream(stream, version);
}

}  // namespace tessera::client::mitsuba
