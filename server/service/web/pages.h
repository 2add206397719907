// The page itself: files of server/service/web/pages, built into the program.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tessera::server {

struct PageFile {
  std::string_view type;  // "text/html; charset=utf-8"
  std::string_view bytes;
};

/// The file at a path, "/" the page; none where there is none.
std::optional<PageFile> page_file(std::string_view path);

}  // namespace tessera::server
