#include "fuzz/mutate_message.h"

#include <limits>
#include <string>
#include <vector>

namespace tessera::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr int kMaxElements = 64;

class Mutator {
 public:
  Mutator(const Message& root, std::mt19937& random) : random_(random) {
    gather_strings(root);
    for (const char* text : {"", "x", "../x", "nan"}) strings_.emplace_back(text);
  }

  void edit(Message& message) {
    const Reflection& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> present, children;
    reflection.ListFields(message, &present);
    for (const FieldDescriptor* field : present) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field->is_map())
        children.push_back(field);
    }
    // Mostly deeper, for most of a message is in its leaves.
    if (!children.empty() && below(4) > 0) {
      const FieldDescriptor* const field = children[below(children.size())];
      return edit(field->is_repeated()
                      ? *reflection.MutableRepeatedMessage(&message, field,
                                                           index_below(reflection.FieldSize(message, field)))
                      : *reflection.MutableMessage(&message, field));
    }
    const auto* const descriptor = message.GetDescriptor();
    if (descriptor->field_count() == 0) return;
    // A field that is there, or any.
    const FieldDescriptor* const field = !present.empty() && below(2) == 0
                                             ? present[below(present.size())]
                                             : descriptor->field(index_below(descriptor->field_count()));
    if (field->is_map()) return;
    field->is_repeated() ? edit_repeated(message, field) : edit_single(message, field);
  }

 private:
  std::size_t below(std::size_t bound) { return random_() % bound; }
  int index_below(int bound) { return static_cast<int>(below(static_cast<std::size_t>(bound))); }

  void gather_strings(const Message& message) {
    const Reflection& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      if (field->is_map() || strings_.size() > 64) continue;
      const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
      for (int i = 0; i < count; ++i) {
        if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
          strings_.push_back(field->is_repeated() ? reflection.GetRepeatedString(message, field, i)
                                                  : reflection.GetString(message, field));
        } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
          gather_strings(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                              : reflection.GetMessage(message, field));
        }
      }
    }
  }

  double number() {
    constexpr double kNumbers[] = {0,
                                   -0.0,
                                   1,
                                   -1,
                                   2,
                                   0.5,
                                   1e-3,
                                   1e-30,
                                   1e-45,
                                   1e6,
                                   1e18,
                                   1e30,
                                   3.4e38,
                                   -3.4e38,
                                   360,
                                   std::numeric_limits<double>::quiet_NaN(),
                                   std::numeric_limits<double>::infinity()};
    if (below(2) == 0) return std::uniform_real_distribution<double>(-4, 4)(random_);
    return kNumbers[below(std::size(kNumbers))];
  }

  std::int64_t integer() {
    constexpr std::int64_t kIntegers[] = {0,       1,       2,          3,          7,  64,
                                          1 << 16, 1 << 20, 0x7fffffff, 0xffffffff, -1, 1ll << 40};
    return kIntegers[below(std::size(kIntegers))];
  }

  void edit_single(Message& message, const FieldDescriptor* field) {
    const Reflection& reflection = *message.GetReflection();
    if (below(6) == 0) return reflection.ClearField(&message, field);
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_INT32:
        return reflection.SetInt32(&message, field, static_cast<std::int32_t>(integer()));
      case FieldDescriptor::CPPTYPE_INT64:
        return reflection.SetInt64(&message, field, integer());
      case FieldDescriptor::CPPTYPE_UINT32:
        return reflection.SetUInt32(&message, field, static_cast<std::uint32_t>(integer()));
      case FieldDescriptor::CPPTYPE_UINT64:
        return reflection.SetUInt64(&message, field, static_cast<std::uint64_t>(integer()));
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return reflection.SetDouble(&message, field, number());
      case FieldDescriptor::CPPTYPE_FLOAT:
        return reflection.SetFloat(&message, field, static_cast<float>(number()));
      case FieldDescriptor::CPPTYPE_BOOL:
        return reflection.SetBool(&message, field, below(2) == 0);
      case FieldDescriptor::CPPTYPE_ENUM:
        return reflection.SetEnumValue(&message, field, index_below(field->enum_type()->value_count() + 1));
      case FieldDescriptor::CPPTYPE_STRING:
        return reflection.SetString(&message, field, strings_[below(strings_.size())]);
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return edit(*reflection.MutableMessage(&message, field));
    }
  }

  void add_element(Message& message, const FieldDescriptor* field) {
    const Reflection& reflection = *message.GetReflection();
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE: {
        Message& added = *reflection.AddMessage(&message, field);
        const int before = reflection.FieldSize(message, field) - 1;
        if (before > 0 && below(4) > 0) {
          added.CopyFrom(reflection.GetRepeatedMessage(message, field, index_below(before)));
        }
        return edit(added);
      }
      case FieldDescriptor::CPPTYPE_STRING:
        return reflection.AddString(&message, field, strings_[below(strings_.size())]);
      case FieldDescriptor::CPPTYPE_FLOAT:
        return reflection.AddFloat(&message, field, static_cast<float>(number()));
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return reflection.AddDouble(&message, field, number());
      case FieldDescriptor::CPPTYPE_UINT32:
        return reflection.AddUInt32(&message, field, static_cast<std::uint32_t>(integer()));
      case FieldDescriptor::CPPTYPE_ENUM:
        return reflection.AddEnumValue(&message, field, index_below(field->enum_type()->value_count() + 1));
      default:
        return;  // the contract has no other repeated fields
    }
  }

  void edit_repeated(Message& message, const FieldDescriptor* field) {
    const Reflection& reflection = *message.GetReflection();
    const int size = reflection.FieldSize(message, field);
    const std::size_t kind = size == 0 ? 0 : below(4);
    if (kind == 0) {
      if (size < kMaxElements) add_element(message, field);
      return;
    }
    if (kind == 1) return reflection.RemoveLast(&message, field);
    if (kind == 2) return reflection.SwapElements(&message, field, index_below(size), index_below(size));
    const int at = index_below(size);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      edit(*reflection.MutableRepeatedMessage(&message, field, at));
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {
      reflection.SetRepeatedFloat(&message, field, at, static_cast<float>(number()));
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
      reflection.SetRepeatedDouble(&message, field, at, number());
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      reflection.SetRepeatedString(&message, field, at, strings_[below(strings_.size())]);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      reflection.SetRepeatedEnumValue(&message, field, at,
                                      index_below(field->enum_type()->value_count() + 1));
    }
  }

  std::mt19937& random_;
  std::vector<std::string> strings_;
};

}  // namespace

void mutate_message(Message& message, std::mt19937& random) {
  for (std::size_t edits = 1 + random() % 4; edits > 0; --edits) Mutator(message, random).edit(message);
}

}  // namespace tessera::fuzz
