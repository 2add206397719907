#include "wire/message_digest.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "wire/digest.h"

namespace tessera::wire {

std::string digest_of(std::initializer_list<const google::protobuf::MessageLite*> messages) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream out(&stream);
    out.SetSerializationDeterministic(true);
    for (const google::protobuf::MessageLite* const message : messages) {
      // With its length: else the end of one could be the beginning of the next.
      out.WriteVarint64(message->ByteSizeLong());
      message->SerializeToCodedStream(&out);
    }
  }
  return sha256_hex(bytes);
}

}  // namespace tessera::wire
