// Messages of others, made safe for a terminal and for a log.
#pragma once

namespace google::protobuf {
class Message;
}

namespace tessera::wire {

/// Makes every string field printable (base/printable.h), those of the messages in it too; bytes stay.
void make_printable(google::protobuf::Message& message);

}  // namespace tessera::wire
