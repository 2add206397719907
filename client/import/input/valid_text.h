// Text that protobuf accepts.
#pragma once

#include <string>
#include <string_view>

#include "google/protobuf/message.h"

namespace tessera::client {

/// Whether `text` is UTF-8.
bool is_utf8(std::string_view text);

/// Writes every byte that is not part of UTF-8 as %XX in all strings of `message` and below. Older scene
/// files have names in other encodings, and protobuf refuses to read messages with such strings back.
void make_text_valid(google::protobuf::Message& message);

}  // namespace tessera::client
