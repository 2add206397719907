// Digests of messages, as keys of what depends on them alone.
#pragma once

#include <google/protobuf/message_lite.h>

#include <initializer_list>
#include <string>

namespace tessera::wire {

/// SHA-256 of the messages, in this order, as 64 hexadecimal digits. Equal messages have equal digests within
/// one version of the programs; fields that it does not know count too.
std::string digest_of(std::initializer_list<const google::protobuf::MessageLite*> messages);

}  // namespace tessera::wire
