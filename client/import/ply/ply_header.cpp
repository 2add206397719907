#include "import/ply/ply_header.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "import/input/concat.h"

namespace tessera::client {
namespace {

// Longer headers do not occur; comments may be long, but not megabytes.
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;

std::optional<PlyType> type_of_name(std::string_view name) {
  if (name == "char" || name == "int8") return PlyType::kInt8;
  if (name == "uchar" || name == "uint8") return PlyType::kUint8;
  if (name == "short" || name == "int16") return PlyType::kInt16;
  if (name == "ushort" || name == "uint16") return PlyType::kUint16;
  if (name == "int" || name == "int32") return PlyType::kInt32;
  if (name == "uint" || name == "uint32") return PlyType::kUint32;
  if (name == "float" || name == "float32") return PlyType::kFloat32;
  if (name == "double" || name == "float64") return PlyType::kFloat64;
  return std::nullopt;
}

std::optional<PlyFormat> format_of_name(std::string_view name) {
  if (name == "ascii") return PlyFormat::kAscii;
  if (name == "binary_little_endian") return PlyFormat::kBinaryLittleEndian;
  if (name == "binary_big_endian") return PlyFormat::kBinaryBigEndian;
  return std::nullopt;
}

using Words = std::vector<std::string_view>;

Words split(std::string_view line) {
  constexpr std::string_view kSpace = " \t";
  Words words;
  for (std::size_t begin = line.find_first_not_of(kSpace); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSpace, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSpace, end);
  }
  return words;
}

/// The message of what is wrong with a line, or nothing.
std::string read_format(const Words& words, PlyHeader& header) {
  const std::optional<PlyFormat> format = words.size() == 3 ? format_of_name(words[1]) : std::nullopt;
  if (!format) return "expected \"format ascii|binary_little_endian|binary_big_endian 1.0\"";
  header.format = *format;
  return "";
}

std::string read_element(const Words& words, PlyHeader& header) {
  PlyElement element;
  if (words.size() != 3) return "expected \"element NAME COUNT\"";
  element.name = words[1];
  const char* end = words[2].data() + words[2].size();
  if (const auto result = std::from_chars(words[2].data(), end, element.count);
      result.ec != std::errc{} || result.ptr != end) {
    return concat("expected a count, found \"", words[2], "\"");
  }
  header.elements.push_back(std::move(element));
  return "";
}

std::string read_property(const Words& words, PlyHeader& header) {
  if (header.elements.empty()) return "a property before any element";
  PlyProperty property;
  property.is_list = words.size() == 5 && words[1] == "list";
  if (!property.is_list && words.size() != 3) {
    return "expected \"property TYPE NAME\" or \"property list COUNT_TYPE TYPE NAME\"";
  }
  const std::optional<PlyType> type = type_of_name(words[words.size() - 2]);
  if (!type) return concat("unknown type \"", words[words.size() - 2], "\"");
  property.type = *type;
  property.name = words.back();
  if (property.is_list) {
    const std::optional<PlyType> count_type = type_of_name(words[2]);
    if (!count_type || !is_integer(*count_type)) {
      return concat("expected an integer type for the length of the list, found \"", words[2], "\"");
    }
    property.list_count_type = *count_type;
  }
  header.elements.back().properties.push_back(std::move(property));
  return "";
}

}  // namespace

std::size_t byte_size(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

bool is_integer(PlyType type) { return type != PlyType::kFloat32 && type != PlyType::kFloat64; }

int PlyElement::find(std::string_view property) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return static_cast<int>(i);
  }
  return -1;
}

bool PlyElement::is_fixed_size() const {
  return std::none_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

std::size_t PlyElement::min_bytes(PlyFormat format) const {
  if (format == PlyFormat::kAscii) return 2 * properties.size();  // a digit and a separator
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += byte_size(property.is_list ? property.list_count_type : property.type);
  return bytes;
}

absl::StatusOr<PlyHeader> read_ply_header(std::string_view bytes) {
  PlyHeader header;
  const std::string_view text = bytes.substr(0, kMaxHeaderBytes);
  bool has_format = false;
  while (true) {
    const std::size_t end = text.find('\n', header.data_offset);
    if (end == std::string_view::npos) {
      return absl::InvalidArgumentError(header.header_lines == 0
                                            ? "line 1: not a PLY file: it does not begin with \"ply\""
                                            : "the header has no \"end_header\"");
    }
    std::string_view line = text.substr(header.data_offset, end - header.data_offset);
    header.data_offset = end + 1;
    ++header.header_lines;
    if (line.ends_with('\r')) line.remove_suffix(1);
    const Words words = split(line);

    std::string problem;
    if (header.header_lines == 1) {
      if (line != "ply") problem = "not a PLY file: it does not begin with \"ply\"";
    } else if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      continue;
    } else if (words[0] == "format") {
      problem = read_format(words, header);
      has_format = true;
    } else if (words[0] == "element") {
      problem = read_element(words, header);
    } else if (words[0] == "property") {
      problem = read_property(words, header);
    } else if (words[0] == "end_header") {
      if (has_format) return header;
      problem = "the header has no \"format\"";
    } else {
      problem = concat("expected format, element, property, comment or end_header, found \"", words[0], "\"");
    }
    if (!problem.empty())
      return absl::InvalidArgumentError(concat("line ", header.header_lines, ": ", problem));
  }
}

}  // namespace tessera::client
