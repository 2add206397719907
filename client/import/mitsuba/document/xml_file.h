// An XML file with places in it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "import/input/diagnostics.h"
#include "pugixml.hpp"

namespace tessera::client::mitsuba {

class XmlFile {
 public:
  /// Parses the file; false, with an error at `included_from` or in the file, when that fails.
  bool load(const std::filesystem::path& path, SourceLocation included_from, Diagnostics& diagnostics);

  std::size_t size() const { return size_; }  // bytes
  pugi::xml_node root() const { return document_.document_element(); }
  SourceLocation locate(const pugi::xml_node& node) const { return locate(node.offset_debug()); }

 private:
  SourceLocation locate(std::ptrdiff_t offset) const;

  pugi::xml_document document_;
  std::vector<std::size_t> line_starts_;
  std::uint32_t file_ = 0;
  std::size_t size_ = 0;
};

}  // namespace tessera::client::mitsuba
