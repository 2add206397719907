#include "import/pbrt/import_pbrt.h"

#include "import/input/valid_text.h"
#include "import/pbrt/file/directive_reader.h"

namespace tessera::client::pbrt {

absl::StatusOr<ImportedScene> import_pbrt(const std::filesystem::path& path, int threads) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return absl::NotFoundError(path.string() + ": no such file");
  }
  Context context;
  context.directory = path.parent_path();
  context.threads = threads;
  {
    DirectiveHandler builder(context);
    DirectiveReader reader(context, builder);
    reader.read_file(path, SourceLocation{});
    if (!context.diagnostics.full()) builder.finish();
  }  // whose parameters say at their end what nobody asked for
  if (absl::Status status = context.diagnostics.status(); !status.ok()) return status;

  std::filesystem::path name = path.filename();
  if (name.extension() == ".gz") name = name.stem();
  context.scene.set_name(name.stem().string());
  make_text_valid(context.scene);
  ImportedScene result;
  result.scene = std::move(context.scene);
  result.blobs = context.blobs.take();
  for (SceneBlob& blob : result.blobs) make_text_valid(blob.ref);
  result.warnings = context.diagnostics.warnings();
  return result;
}

}  // namespace tessera::client::pbrt
