#include "wire/printable_message.h"

#include <google/protobuf/message.h>

#include <vector>

#include "base/printable.h"

namespace tessera::wire {

void make_printable(google::protobuf::Message& message) {
  using google::protobuf::FieldDescriptor;
  const google::protobuf::Reflection& fields = *message.GetReflection();
  std::vector<const FieldDescriptor*> set;
  fields.ListFields(message, &set);
  for (const FieldDescriptor* const field : set) {
    const int count = field->is_repeated() ? fields.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->type() == FieldDescriptor::TYPE_STRING) {
        if (field->is_repeated()) {
          fields.SetRepeatedString(&message, field, i,
                                   base::printable(fields.GetRepeatedString(message, field, i)));
        } else {
          fields.SetString(&message, field, base::printable(fields.GetString(message, field)));
        }
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        make_printable(field->is_repeated() ? *fields.MutableRepeatedMessage(&message, field, i)
                                            : *fields.MutableMessage(&message, field));
      }
    }
  }
}

}  // namespace tessera::wire
