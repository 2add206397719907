// JSON of what others wrote.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tessera::server {

/// On one line; bytes that are not UTF-8 are replaced.
inline std::string json_text(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tessera::server
