#include "import/mitsuba/document/xml_file.h"

#include <algorithm>

#include "import/input/concat.h"
#include "import/input/input_file.h"

namespace tessera::client::mitsuba {

bool XmlFile::load(const std::filesystem::path& path, SourceLocation included_from,
                   Diagnostics& diagnostics) {
  absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) {
    diagnostics.error(included_from, std::string(file.status().message()));
    return false;
  }
  file_ = diagnostics.add_file(path.string());
  const std::string_view bytes = file->bytes();
  size_ = bytes.size();
  line_starts_ = {0};
  for (std::size_t i = bytes.find('\n'); i != std::string_view::npos; i = bytes.find('\n', i + 1)) {
    line_starts_.push_back(i + 1);
  }
  const pugi::xml_parse_result result = document_.load_buffer(bytes.data(), bytes.size());
  if (!result) {
    diagnostics.error(locate(result.offset + 1), concat("not well-formed XML: ", result.description()));
    return false;
  }
  return true;
}

SourceLocation XmlFile::locate(std::ptrdiff_t offset) const {
  if (offset < 0) return {file_, 0, 0};
  const auto position = static_cast<std::size_t>(offset);
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), position);
  const std::size_t line = static_cast<std::size_t>(next - line_starts_.begin());
  // The offset is that of the name behind "<"; columns count from 1.
  const std::size_t column = std::max<std::size_t>(1, position - line_starts_[line - 1]);
  return {file_, static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(column)};
}

}  // namespace tessera::client::mitsuba
