// Mutations of protobuf messages: what comes out parses again, so that fuzzing gets behind the parser.
#pragma once

#include <random>

#include "google/protobuf/message.h"

namespace tessera::fuzz {

/// One to four edits anywhere within the message: fields set to extreme values, cleared, added, elements
/// doubled, dropped and swapped, strings replaced by others of the same message, so that references meet.
void mutate_message(google::protobuf::Message& message, std::mt19937& random);

}  // namespace tessera::fuzz
