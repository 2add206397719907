#include "import/ply/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "import/input/concat.h"
#include "import/ply/ply_header.h"

namespace tessera::client {
namespace {

static_assert(std::endian::native == std::endian::little, "binary values are read in place");

constexpr std::uint64_t kMaxVertices = std::uint64_t{1} << 31;  // limit of a mesh blob
constexpr std::uint64_t kMaxTriangles = std::uint64_t{1} << 31;

template <typename T>
T load(const char* p, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), p, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

double load_value(const char* p, PlyType type, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return load<std::int8_t>(p, swap);
    case PlyType::kUint8:
      return load<std::uint8_t>(p, swap);
    case PlyType::kInt16:
      return load<std::int16_t>(p, swap);
    case PlyType::kUint16:
      return load<std::uint16_t>(p, swap);
    case PlyType::kInt32:
      return load<std::int32_t>(p, swap);
    case PlyType::kUint32:
      return load<std::uint32_t>(p, swap);
    case PlyType::kFloat32:
      return load<float>(p, swap);
    case PlyType::kFloat64:
      return load<double>(p, swap);
  }
  return 0;
}

/// Walks over the data behind the header, value by value.
class PlyCursor {
 public:
  PlyCursor(std::string_view bytes, const PlyHeader& header)
      : begin_(bytes.data()),
        p_(bytes.data() + header.data_offset),
        end_(bytes.data() + bytes.size()),
        line_(header.header_lines + 1),
        format_(header.format) {}

  bool is_ascii() const { return format_ == PlyFormat::kAscii; }
  bool swaps() const { return format_ == PlyFormat::kBinaryBigEndian; }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - p_); }
  const char* position() const { return p_; }
  void skip(std::size_t bytes) { p_ += bytes; }

  /// The next value; false at the end of the file or where there is no number.
  bool read(PlyType type, double& value) {
    if (is_ascii()) return read_ascii(value);
    const std::size_t size = byte_size(type);
    if (remaining() < size) return false;
    value = load_value(p_, type, swaps());
    p_ += size;
    return true;
  }

  /// Where reading stands, for messages.
  std::string place() const {
    return is_ascii() ? concat("line ", line_) : concat("byte ", static_cast<std::size_t>(p_ - begin_));
  }

 private:
  bool read_ascii(double& value) {
    while (p_ < end_ && (*p_ == ' ' || *p_ == '\n' || *p_ == '\r' || *p_ == '\t')) {
      if (*p_ == '\n') ++line_;
      ++p_;
    }
    if (p_ < end_ && *p_ == '+') ++p_;
    const auto [rest, error] = std::from_chars(p_, end_, value);
    if (error == std::errc::result_out_of_range)
      value = 0;  // smaller than any double
    else if (error != std::errc{})
      return false;
    p_ = rest;
    return true;
  }

  const char* begin_;
  const char* p_;
  const char* end_;
  std::uint32_t line_;
  PlyFormat format_;
};

/// Where a property of the vertex element goes.
struct VertexTarget {
  std::vector<float>* array = nullptr;
  std::size_t stride = 0;  // floats a vertex
  std::size_t component = 0;
};

class PlyMeshReader {
 public:
  PlyMeshReader(std::string_view bytes, const PlyHeader& header, bool with_attributes)
      : header_(header), cursor_(bytes, header), with_attributes_(with_attributes) {}

  absl::StatusOr<PlyMesh> read() {
    for (const PlyElement& element : header_.elements) {
      if (absl::Status status = check_count(element); !status.ok()) return status;
      absl::Status status;
      if (element.name == "vertex") {
        status = read_vertices(element);
      } else if (element.name == "face") {
        status = read_faces(element);
      } else {
        status = skip_element(element);
      }
      if (!status.ok()) return status;
    }
    if (absl::Status status = finish(); !status.ok()) return status;
    return std::move(result_);
  }

 private:
  absl::Status fail(std::string_view what) const {
    return absl::InvalidArgumentError(concat(cursor_.place(), ": ", what));
  }
  absl::Status fail_element(const PlyElement& element, std::uint64_t index, std::string_view what) const {
    return fail(concat(element.name, " ", index, ": ", what));
  }

  absl::Status check_count(const PlyElement& element) const {
    if (element.count == 0) return absl::OkStatus();
    const std::size_t min_bytes = element.min_bytes(header_.format);
    // The last value of an ascii file needs no separator.
    const std::size_t available = cursor_.remaining() + (cursor_.is_ascii() ? 1 : 0);
    if (min_bytes == 0 || element.count > available / min_bytes) {
      return fail(concat("the header claims ", element.count, " of element \"", element.name,
                         "\", but the file ends after ", cursor_.remaining(), " more bytes: it is cut off"));
    }
    return absl::OkStatus();
  }

  absl::Status skip_property(const PlyElement& element, const PlyProperty& property, std::uint64_t index) {
    double value = 0;
    if (!property.is_list) {
      return cursor_.read(property.type, value) ? absl::OkStatus()
                                                : fail_element(element, index, "the data end here");
    }
    if (!cursor_.read(property.list_count_type, value) || !(value >= 0)) {
      return fail_element(element, index, "expected the length of a list");
    }
    const auto length = static_cast<std::uint64_t>(value);
    if (!cursor_.is_ascii()) {
      if (length > cursor_.remaining() / byte_size(property.type))
        return fail_element(element, index, "the data end here");
      cursor_.skip(length * byte_size(property.type));
      return absl::OkStatus();
    }
    for (std::uint64_t i = 0; i < length; ++i) {
      if (!cursor_.read(property.type, value)) return fail_element(element, index, "the data end here");
    }
    return absl::OkStatus();
  }

  absl::Status skip_element(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (absl::Status status = skip_property(element, property, i); !status.ok()) return status;
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<VertexTarget>> vertex_targets(const PlyElement& element);
  absl::Status read_vertices(const PlyElement& element);
  void read_fixed_vertices(const PlyElement& element, const std::vector<VertexTarget>& targets);
  absl::Status read_faces(const PlyElement& element);
  bool read_packed_triangles(const PlyElement& element, const PlyProperty& list);
  absl::Status add_polygon(const PlyElement& element, std::uint64_t index);
  absl::Status finish();
  void warn_of_warped_quads();

  const PlyHeader& header_;
  PlyCursor cursor_;
  const bool with_attributes_;
  PlyMesh result_;
  std::vector<PlyAttribute> vertex_attributes_, face_attributes_;
  bool has_vertices_ = false;
  bool has_faces_ = false;
  std::vector<std::uint32_t> polygon_;  // the face being read
  std::vector<std::size_t> quads_;      // first index of each pair of triangles that was a quad
  std::uint64_t larger_polygons_ = 0;
  std::uint64_t degenerate_polygons_ = 0;
};

absl::StatusOr<std::vector<VertexTarget>> PlyMeshReader::vertex_targets(const PlyElement& element) {
  wire::MeshData& mesh = result_.mesh;
  std::vector<VertexTarget> targets(element.properties.size());
  const auto assign = [&](std::initializer_list<std::string_view> names, std::vector<float>& array) {
    for (const std::string_view name : names) {
      const int index = element.find(name);
      if (index < 0 || element.properties[index].is_list) return false;
    }
    std::size_t component = 0;
    for (const std::string_view name : names)
      targets[element.find(name)] = {&array, names.size(), component++};
    array.resize(element.count * names.size());
    return true;
  };
  if (!assign({"x", "y", "z"}, mesh.positions)) return fail("vertices have no properties x, y, z");
  assign({"nx", "ny", "nz"}, mesh.normals);
  for (const auto& [u, v] :
       {std::pair{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}) {
    if (assign({u, v}, mesh.uvs)) break;
  }
  if (with_attributes_) {
    vertex_attributes_ = plan_attributes(element, false, result_.warnings);
    for (PlyAttribute& attribute : vertex_attributes_) {
      attribute.values.resize(element.count * attribute.channels);
      for (std::uint32_t c = 0; c < attribute.channels; ++c) {
        targets[attribute.properties[c]] = {&attribute.values, attribute.channels, c};
      }
    }
  }
  return targets;
}

absl::Status PlyMeshReader::read_vertices(const PlyElement& element) {
  if (has_vertices_) return fail("a second vertex element");
  has_vertices_ = true;
  if (element.count > kMaxVertices) return fail("more than 2^31 vertices");
  absl::StatusOr<std::vector<VertexTarget>> targets = vertex_targets(element);
  if (!targets.ok()) return targets.status();

  if (!cursor_.is_ascii() && element.is_fixed_size()) {
    read_fixed_vertices(element, *targets);
  } else {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const VertexTarget& target = (*targets)[p];
        if (target.array == nullptr) {
          if (absl::Status status = skip_property(element, element.properties[p], i); !status.ok())
            return status;
          continue;
        }
        double value = 0;
        if (!cursor_.read(element.properties[p].type, value))
          return fail_element(element, i, "expected a number");
        (*target.array)[i * target.stride + target.component] = static_cast<float>(value);
      }
    }
  }
  const std::vector<float>* arrays[] = {&result_.mesh.positions, &result_.mesh.normals, &result_.mesh.uvs};
  const std::size_t strides[] = {3, 3, 2};
  const std::string_view names[] = {"position", "normal", "texture coordinate"};
  for (int a = 0; a < 3; ++a) {
    const auto bad =
        std::find_if(arrays[a]->begin(), arrays[a]->end(), [](float v) { return !std::isfinite(v); });
    if (bad == arrays[a]->end()) continue;
    const std::size_t vertex = static_cast<std::size_t>(bad - arrays[a]->begin()) / strides[a];
    return absl::InvalidArgumentError(concat("vertex ", vertex, ": its ", names[a], " is not finite"));
  }
  return absl::OkStatus();
}

void PlyMeshReader::read_fixed_vertices(const PlyElement& element, const std::vector<VertexTarget>& targets) {
  if (element.count == 0) return;
  // check_count has made sure that all bytes are there.
  const std::size_t record = element.min_bytes(header_.format);
  const char* const data = cursor_.position();
  const bool swap = cursor_.swaps();
  std::size_t offset = 0;
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const PlyType type = element.properties[p].type;
    const VertexTarget& target = targets[p];
    if (target.array != nullptr) {
      float* out = target.array->data() + target.component;
      const char* in = data + offset;
      if (type == PlyType::kFloat32 && !swap) {
        for (std::uint64_t i = 0; i < element.count; ++i, in += record, out += target.stride) {
          std::memcpy(out, in, sizeof(float));
        }
      } else {
        for (std::uint64_t i = 0; i < element.count; ++i, in += record, out += target.stride) {
          *out = static_cast<float>(load_value(in, type, swap));
        }
      }
    }
    offset += byte_size(type);
  }
  cursor_.skip(element.count * record);
}

absl::Status PlyMeshReader::read_faces(const PlyElement& element) {
  if (has_faces_) return fail("a second face element");
  has_faces_ = true;
  int list = element.find("vertex_indices");
  if (list < 0) list = element.find("vertex_index");
  if (list < 0 || !element.properties[list].is_list || !is_integer(element.properties[list].type)) {
    return fail("faces have no integer list vertex_indices");
  }
  if (read_packed_triangles(element, element.properties[list])) return absl::OkStatus();
  if (with_attributes_) face_attributes_ = plan_attributes(element, true, result_.warnings);
  std::vector<double> scalars(element.properties.size());
  std::vector<bool> wanted(element.properties.size());
  for (const PlyAttribute& attribute : face_attributes_) {
    for (const int property : attribute.properties) wanted[property] = true;
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    const std::size_t triangles_before = result_.mesh.indices.size() / 3;
    for (int p = 0; p < static_cast<int>(element.properties.size()); ++p) {
      const PlyProperty& property = element.properties[p];
      if (wanted[p]) {
        if (!cursor_.read(property.type, scalars[p])) return fail_element(element, i, "expected a number");
        continue;
      }
      if (p != list) {
        if (absl::Status status = skip_property(element, property, i); !status.ok()) return status;
        continue;
      }
      double length = 0;
      if (!cursor_.read(property.list_count_type, length) || !(length >= 0) || length > 1e9) {
        return fail_element(element, i, "expected the number of its vertices");
      }
      polygon_.clear();
      for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(length); ++k) {
        double value = 0;
        if (!cursor_.read(property.type, value))
          return fail_element(element, i, "the data end in its vertex list");
        if (!(value >= 0) || value > std::numeric_limits<std::uint32_t>::max() ||
            value != std::floor(value)) {
          return fail_element(element, i, concat("vertex index ", value, " is out of range"));
        }
        polygon_.push_back(static_cast<std::uint32_t>(value));
      }
      if (absl::Status status = add_polygon(element, i); !status.ok()) return status;
    }
    const std::size_t triangles = result_.mesh.indices.size() / 3 - triangles_before;
    for (PlyAttribute& attribute : face_attributes_) attribute.append(scalars, triangles);
  }
  return absl::OkStatus();
}

/// The common case in one sweep: binary, this machine's byte order, one list of 32-bit indices, only
/// triangles.
bool PlyMeshReader::read_packed_triangles(const PlyElement& element, const PlyProperty& list) {
  constexpr std::size_t kRecord = 1 + 3 * sizeof(std::uint32_t);
  const bool packed = header_.format == PlyFormat::kBinaryLittleEndian && element.properties.size() == 1 &&
                      byte_size(list.list_count_type) == 1 && byte_size(list.type) == sizeof(std::uint32_t);
  if (!packed || element.count > cursor_.remaining() / kRecord || element.count > kMaxTriangles) return false;
  const char* in = cursor_.position();
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (in[i * kRecord] != 3) return false;
  }
  std::vector<std::uint32_t>& indices = result_.mesh.indices;
  indices.resize(3 * element.count);
  for (std::uint64_t i = 0; i < element.count; ++i, in += kRecord)
    std::memcpy(&indices[3 * i], in + 1, kRecord - 1);
  cursor_.skip(element.count * kRecord);
  return true;
}

absl::Status PlyMeshReader::add_polygon(const PlyElement& element, std::uint64_t index) {
  std::vector<std::uint32_t>& indices = result_.mesh.indices;
  if (polygon_.size() < 3) {
    ++degenerate_polygons_;
    return absl::OkStatus();
  }
  if (indices.size() / 3 + polygon_.size() > kMaxTriangles)
    return fail_element(element, index, "more than 2^31 triangles");
  if (polygon_.size() == 4) quads_.push_back(indices.size());
  if (polygon_.size() > 4) ++larger_polygons_;
  for (std::size_t k = 2; k < polygon_.size(); ++k) {
    indices.insert(indices.end(), {polygon_[0], polygon_[k - 1], polygon_[k]});
  }
  return absl::OkStatus();
}

absl::Status PlyMeshReader::finish() {
  if (!has_vertices_) return absl::InvalidArgumentError("the file has no vertex element");
  if (!has_faces_) return absl::InvalidArgumentError("the file has no face element");
  const std::vector<std::uint32_t>& indices = result_.mesh.indices;
  const std::size_t vertices = result_.mesh.positions.size() / 3;
  const auto bad =
      std::find_if(indices.begin(), indices.end(), [&](std::uint32_t i) { return i >= vertices; });
  if (bad != indices.end()) {
    return absl::InvalidArgumentError(concat("triangle ", (bad - indices.begin()) / 3, ": vertex index ",
                                             *bad, " is out of range: there are ", vertices, " vertices"));
  }
  for (std::vector<PlyAttribute>* attributes : {&vertex_attributes_, &face_attributes_}) {
    for (PlyAttribute& attribute : *attributes) {
      if (absl::Status status = attribute.finish(); !status.ok()) return status;
      result_.attributes.push_back(std::move(attribute));
    }
  }
  warn_of_warped_quads();
  if (larger_polygons_ > 0) {
    result_.warnings.push_back(
        concat(larger_polygons_, " faces have more than four vertices: cut into fans"));
  }
  if (degenerate_polygons_ > 0) {
    result_.warnings.push_back(
        concat(degenerate_polygons_, " faces have fewer than three vertices: left out"));
  }
  return absl::OkStatus();
}

void PlyMeshReader::warn_of_warped_quads() {
  // The volume of the tetrahedron over the four corners, against the cube of the quad's size.
  constexpr double kWarped = 1e-3;
  const wire::MeshData& mesh = result_.mesh;
  std::size_t warped = 0;
  for (const std::size_t first : quads_) {
    const std::uint32_t corner[] = {mesh.indices[first], mesh.indices[first + 1], mesh.indices[first + 2],
                                    mesh.indices[first + 5]};
    double e[3][3];
    double size_squared = 0;
    for (int k = 0; k < 3; ++k) {
      for (int a = 0; a < 3; ++a) {
        e[k][a] = double{mesh.positions[3 * std::size_t{corner[k + 1]} + a]} -
                  mesh.positions[3 * std::size_t{corner[0]} + a];
      }
      size_squared = std::max(size_squared, e[k][0] * e[k][0] + e[k][1] * e[k][1] + e[k][2] * e[k][2]);
    }
    const double volume = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                          e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    if (std::abs(volume) > kWarped * size_squared * std::sqrt(size_squared)) ++warped;
  }
  if (warped > 0) {
    result_.warnings.push_back(concat(warped, " quads are not flat: each is cut into two triangles"));
  }
}

}  // namespace

absl::StatusOr<PlyMesh> read_ply(std::string_view bytes, bool with_attributes) {
  absl::StatusOr<PlyHeader> header = read_ply_header(bytes);
  if (!header.ok()) return header.status();
  return PlyMeshReader(bytes, *header, with_attributes).read();
}

}  // namespace tessera::client
