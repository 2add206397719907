#include "support/picture/scene_file.h"

#include <google/protobuf/text_format.h>

#include <fstream>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "import/import.h"
#include "render/scene/load_scene.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"

namespace tessera::test {

namespace {

v1::JobSpec resolve(const v1::Scene& scene, const SceneJob& job) {
  v1::JobSpec spec;
  v1::RenderSettings asked = scene.settings();
  asked.MergeFrom(job.settings);
  wire::resolve_settings(asked, spec);
  // Left to the client in all else.
  if (job.settings.path_sharing() == v1::PATH_SHARING_AUTO)
    spec.mutable_view()->set_path_sharing(v1::PATH_SHARING_AUTO);
  spec.mutable_view()->set_width(job.width != 0 ? job.width : scene.film().width());
  spec.mutable_view()->set_height(job.height != 0 ? job.height : scene.film().height());
  if (wire::find_algorithm(spec.content().algorithms().integrator()) != nullptr) wire::add_phases(spec);
  for (const v1::AOV aov : job.aovs) spec.mutable_view()->add_aovs(aov);
  return spec;
}

absl::StatusOr<render::BlobBytes> whole_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  std::ostringstream out;
  out << in.rdbuf();
  auto bytes = std::make_shared<std::string>(std::move(out).str());
  return render::BlobBytes{*bytes, bytes};
}

}  // namespace

absl::StatusOr<LoadedFile> load_scene_file(const std::string& path, const SceneJob& job,
                                           const std::string& isa, int threads,
                                           const std::function<void(v1::Scene&)>& edit) {
  auto imported = client::import_scene(path);
  if (!imported.ok()) return imported.status();
  if (edit) edit(imported->scene);
  v1::JobSpec spec = resolve(imported->scene, job);
  std::map<std::string, const client::SceneBlob*> blobs;
  for (const client::SceneBlob& blob : imported->blobs) blobs[blob.ref.digest()] = &blob;
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto it = blobs.find(digest);
    if (it == blobs.end()) return absl::NotFoundError(absl::StrCat("blob ", digest));
    if (!it->second->file.empty()) return whole_file(it->second->file);
    return render::BlobBytes{it->second->bytes, nullptr};
  };
  auto scene = render::load_scene(imported->scene, spec, source, {isa, threads});
  if (!scene.ok()) return scene.status();
  return LoadedFile{std::move(spec), *std::move(scene)};
}

absl::StatusOr<LoadedFile> load_scene_text(const std::string& text, const SceneJob& job,
                                           const std::string& isa, const TestBlobs& blobs) {
  v1::Scene scene;
  if (!google::protobuf::TextFormat::ParseFromString(text, &scene)) {
    return absl::InvalidArgumentError("the scene's text does not parse");
  }
  v1::JobSpec spec = resolve(scene, job);
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto it = blobs.find(digest);
    if (it == blobs.end()) return absl::NotFoundError(absl::StrCat("blob ", digest));
    return render::BlobBytes{it->second, nullptr};
  };
  auto loaded = render::load_scene(scene, spec, source, {isa, 1});
  if (!loaded.ok()) return loaded.status();
  return LoadedFile{std::move(spec), *std::move(loaded)};
}

}  // namespace tessera::test
