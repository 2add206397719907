#include "import/obj/obj_reader.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "import/input/concat.h"

namespace tessera::client {
namespace {

constexpr std::size_t kMaxElements = std::size_t{1} << 31;  // limit of a mesh blob
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Position, texture coordinate and normal of a corner; kNone where it has none.
using Corner = std::array<std::uint32_t, 3>;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Walks along one line.
class LineCursor {
 public:
  explicit LineCursor(std::string_view line) : p_(line.data()), end_(line.data() + line.size()) {}

  void skip_blanks() {
    while (p_ < end_ && is_blank(*p_)) ++p_;
  }
  bool at_end() {
    skip_blanks();
    return p_ >= end_;
  }
  bool consume(char c) {
    if (p_ >= end_ || *p_ != c) return false;
    ++p_;
    return true;
  }
  bool at_word_end() const { return p_ >= end_ || is_blank(*p_); }

  bool read(float& value) {
    skip_blanks();
    if (p_ < end_ && *p_ == '+') ++p_;
    const auto [rest, error] = std::from_chars(p_, end_, value);
    if (error == std::errc::result_out_of_range) return read_extreme(value);
    if (error != std::errc{}) return false;
    p_ = rest;
    return true;
  }
  bool read(std::int64_t& value) {
    const auto [rest, error] = std::from_chars(p_, end_, value);
    if (error != std::errc{}) return false;
    p_ = rest;
    return true;
  }

 private:
  /// A number that no float can hold: too small becomes zero, too large infinite.
  bool read_extreme(float& value) {
    double wide = 0;
    const auto [rest, error] = std::from_chars(p_, end_, wide);
    p_ = rest;
    value = error == std::errc{} ? static_cast<float>(wide) : 0.0f;
    return true;
  }

  const char* p_;
  const char* end_;
};

class ObjReader {
 public:
  absl::StatusOr<ObjMesh> read(std::string_view bytes) {
    const std::size_t guess = bytes.size() / 100;
    positions_.reserve(3 * guess);
    for (std::size_t begin = 0; begin < bytes.size();) {
      std::size_t end = bytes.find('\n', begin);
      if (end == std::string_view::npos) end = bytes.size();
      ++line_;
      if (std::string problem = read_line(bytes.substr(begin, end - begin)); !problem.empty()) {
        return absl::InvalidArgumentError(concat("line ", line_, ": ", problem));
      }
      begin = end + 1;
    }
    if (result_.mesh.indices.empty()) return absl::InvalidArgumentError("the file has no faces");
    finish();
    return std::move(result_);
  }

 private:
  /// The message of what is wrong, or nothing.
  std::string read_line(std::string_view line) {
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    if (line.size() < 2) return "";
    if (line[0] == 'v' && is_blank(line[1])) return read_floats(line.substr(2), 3, positions_, "position");
    if (line[0] == 'f' && is_blank(line[1])) return read_face(line.substr(2));
    if (line.size() < 3 || line[0] != 'v' || !is_blank(line[2])) return "";
    if (line[1] == 'n') return read_floats(line.substr(3), 3, normals_, "normal");
    if (line[1] == 't') return read_floats(line.substr(3), 2, uvs_, "texture coordinate");
    return "";
  }

  static std::string read_floats(std::string_view text, int count, std::vector<float>& array,
                                 std::string_view what) {
    LineCursor cursor(text);
    for (int i = 0; i < count; ++i) {
      float value = 0;
      // A texture coordinate may be one-dimensional.
      if (count == 2 && i == 1 && cursor.at_end()) {
        array.push_back(0);
        continue;
      }
      if (!cursor.read(value)) return concat("expected the ", count, " numbers of a ", what);
      if (!std::isfinite(value)) return concat("a ", what, " is not finite");
      array.push_back(value);
    }
    return "";
  }

  /// From the file's index, which counts from 1 or, when negative, from the end.
  static std::string resolve(std::int64_t index, std::size_t count, std::string_view what,
                             std::uint32_t& resolved) {
    const std::int64_t from_zero = index > 0 ? index - 1 : static_cast<std::int64_t>(count) + index;
    if (index == 0 || from_zero < 0 || static_cast<std::size_t>(from_zero) >= count) {
      return concat(what, " index ", index, " is out of range: there are ", count, " so far");
    }
    resolved = static_cast<std::uint32_t>(from_zero);
    return "";
  }

  std::string read_corner(LineCursor& cursor, Corner& corner) {
    corner = {kNone, kNone, kNone};
    std::int64_t index = 0;
    if (!cursor.read(index)) return "expected a vertex index";
    if (std::string problem = resolve(index, positions_.size() / 3, "vertex", corner[0]); !problem.empty()) {
      return problem;
    }
    if (!cursor.consume('/')) return cursor.at_word_end() ? "" : "expected v, v/vt, v//vn or v/vt/vn";
    if (cursor.read(index)) {
      std::string problem = resolve(index, uvs_.size() / 2, "texture coordinate", corner[1]);
      if (!problem.empty()) return problem;
    }
    if (cursor.consume('/') && !cursor.at_word_end()) {
      if (!cursor.read(index)) return "expected a normal index";
      std::string problem = resolve(index, normals_.size() / 3, "normal", corner[2]);
      if (!problem.empty()) return problem;
    }
    return cursor.at_word_end() ? "" : "expected v, v/vt, v//vn or v/vt/vn";
  }

  std::string read_face(std::string_view text) {
    LineCursor cursor(text);
    std::uint32_t first = 0, previous = 0;
    std::size_t count = 0;
    for (; !cursor.at_end(); ++count) {
      Corner corner;
      if (std::string problem = read_corner(cursor, corner); !problem.empty()) return problem;
      const std::uint32_t vertex = vertex_of(corner);
      if (count == 0) first = vertex;
      if (count >= 2) result_.mesh.indices.insert(result_.mesh.indices.end(), {first, previous, vertex});
      previous = vertex;
    }
    if (result_.mesh.indices.size() / 3 > kMaxElements || corners_.size() > kMaxElements) {
      return "more than 2^31 triangles or vertices";
    }
    if (count < 3) ++degenerate_faces_;
    return "";
  }

  /// The vertex of these indices: corners of one position are chained, so that the same ones are found again.
  std::uint32_t vertex_of(const Corner& corner) {
    if (first_of_position_.size() < positions_.size() / 3)
      first_of_position_.resize(positions_.size() / 3, kNone);
    std::uint32_t* link = &first_of_position_[corner[0]];
    while (*link != kNone) {
      if (corners_[*link] == corner) return *link;
      link = &next_[*link];
    }
    const auto vertex = static_cast<std::uint32_t>(corners_.size());
    *link = vertex;
    corners_.push_back(corner);
    next_.push_back(kNone);
    return vertex;
  }

  void finish() {
    std::size_t without_uv = 0, without_normal = 0;
    for (const Corner& corner : corners_) {
      without_uv += corner[1] == kNone;
      without_normal += corner[2] == kNone;
    }
    wire::MeshData& mesh = result_.mesh;
    const bool has_uvs = without_uv < corners_.size(), has_normals = without_normal == 0;
    mesh.positions.reserve(3 * corners_.size());
    if (has_uvs) mesh.uvs.reserve(2 * corners_.size());
    if (has_normals) mesh.normals.reserve(3 * corners_.size());
    for (const Corner& corner : corners_) {
      append(positions_, corner[0], 3, mesh.positions);
      if (has_uvs) append(uvs_, corner[1], 2, mesh.uvs);
      if (has_normals) append(normals_, corner[2], 3, mesh.normals);
    }
    if (has_uvs && without_uv > 0) {
      result_.warnings.push_back(concat(without_uv, " corners have no texture coordinate: (0, 0) is used"));
    }
    if (!has_normals && without_normal < corners_.size()) {
      result_.warnings.push_back(concat(without_normal, " corners have no normal: all normals are left out"));
    }
    if (degenerate_faces_ > 0) {
      result_.warnings.push_back(
          concat(degenerate_faces_, " faces have fewer than three vertices: left out"));
    }
  }

  static void append(const std::vector<float>& from, std::uint32_t index, std::size_t stride,
                     std::vector<float>& to) {
    if (index == kNone) {
      to.insert(to.end(), stride, 0.0f);
      return;
    }
    const auto begin = from.begin() + static_cast<std::ptrdiff_t>(stride * index);
    to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(stride));
  }

  ObjMesh result_;
  std::vector<float> positions_, uvs_, normals_;
  std::vector<Corner> corners_;                   // one for every vertex of the mesh
  std::vector<std::uint32_t> next_;               // chains vertices of the same position
  std::vector<std::uint32_t> first_of_position_;  // head of each chain
  std::size_t line_ = 0;
  std::size_t degenerate_faces_ = 0;
};

}  // namespace

absl::StatusOr<ObjMesh> read_obj(std::string_view bytes) { return ObjReader().read(bytes); }

}  // namespace tessera::client
