#include "wire/resolve_settings.h"

#include <algorithm>

#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/settings.h"

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

/// Copies the fields of `from` that `to` has under the same name.
void copy_by_name(const Message& from, Message& to) {
  const google::protobuf::Reflection &read = *from.GetReflection(), &write = *to.GetReflection();
  for (int i = 0; i < to.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* const target = to.GetDescriptor()->field(i);
    const FieldDescriptor* const source = from.GetDescriptor()->FindFieldByName(target->name());
    if (source == nullptr || source->is_repeated() || !read.HasField(from, source)) continue;
    switch (source->cpp_type()) {
      case FieldDescriptor::CPPTYPE_DOUBLE:
        write.SetDouble(&to, target, read.GetDouble(from, source));
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        write.SetUInt32(&to, target, read.GetUInt32(from, source));
        break;
      case FieldDescriptor::CPPTYPE_UINT64:
        write.SetUInt64(&to, target, read.GetUInt64(from, source));
        break;
      case FieldDescriptor::CPPTYPE_BOOL:
        write.SetBool(&to, target, read.GetBool(from, source));
        break;
      case FieldDescriptor::CPPTYPE_ENUM:
        write.SetEnumValue(&to, target, read.GetEnumValue(from, source));
        break;
      case FieldDescriptor::CPPTYPE_STRING:
        write.SetString(&to, target, read.GetString(from, source));
        break;
      default:
        break;  // messages, of which a job has one; settings_test: jobs have all others
    }
  }
}

}  // namespace

void resolve_settings(const v1::RenderSettings& asked, v1::JobSpec& job) {
  v1::RenderSettings settings = asked;
  fill_in_usual(settings);
  settings.set_max_depth(std::min(settings.max_depth(), kMaxDepth));
  if (settings.reconstruction() == v1::RECONSTRUCTION_AUTO)
    settings.set_reconstruction(v1::RECONSTRUCTION_SAMPLE);
  if (settings.path_sharing() == v1::PATH_SHARING_AUTO) settings.set_path_sharing(v1::PATH_SHARING_OFF);
  v1::Algorithms& algorithms = *job.mutable_content()->mutable_algorithms();
  copy_by_name(settings, algorithms);
  resolve_own_settings(asked, algorithms);
  copy_by_name(settings, *job.mutable_view());
  copy_by_name(settings, *job.mutable_samples());
  if (settings.lens_ghosts() == v1::LENS_GHOSTS_AUTO) job.mutable_view()->clear_lens_ghosts();
  *job.mutable_view()->mutable_layers() = settings.layers();
  job.mutable_view()->set_sample_bits(sample_bits_of(job));
}

void resolve_own_settings(const v1::RenderSettings& asked, v1::Algorithms& algorithms) {
  const FieldDescriptor* const own = own_settings(*algorithms.GetDescriptor(), algorithms.integrator());
  if (own == nullptr) return;
  Message& settings = *algorithms.GetReflection()->MutableMessage(&algorithms, own);
  const FieldDescriptor* const field = asked.GetDescriptor()->FindFieldByName(own->name());
  settings.CopyFrom(asked.GetReflection()->GetMessage(asked, field));
  fill_in_usual(settings);
}

}  // namespace tessera::wire
