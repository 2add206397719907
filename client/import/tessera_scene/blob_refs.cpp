#include "import/tessera_scene/blob_refs.h"

namespace tessera::client::tessera_scene {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using Visit = std::function<void(v1::BlobRef&, bool, int)>;

void visit_message(Message& message, Locations* locations, int line, const Visit& visit) {
  const auto* reflection = message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const int count = field->is_repeated() ? reflection->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      Message& child = field->is_repeated() ? *reflection->MutableRepeatedMessage(&message, field, i)
                                            : *reflection->MutableMessage(&message, field);
      int child_line = line;
      Locations* child_locations = nullptr;
      if (locations != nullptr) {
        const int index = field->is_repeated() ? i : -1;
        const auto location = locations->GetLocation(field, index);
        if (location.line >= 0) child_line = location.line + 1;
        child_locations = locations->GetTreeForNested(field, index);
      }
      if (auto* ref = google::protobuf::DynamicCastToGenerated<v1::BlobRef>(&child)) {
        visit(*ref, message.GetDescriptor() == v1::TriangleMesh::descriptor(), child_line);
      } else {
        visit_message(child, child_locations, child_line, visit);
      }
    }
  }
}

}  // namespace

void for_each_blob_ref(v1::Scene& scene, Locations* locations, const Visit& visit) {
  visit_message(scene, locations, 0, visit);
}

}  // namespace tessera::client::tessera_scene
