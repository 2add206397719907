#include "service/rpc/blob_upload.h"

#include "absl/strings/str_cat.h"
#include "wire/digest.h"
#include "wire/limits.h"

namespace tessera::server {

absl::Status BlobUpload::begin(const v1::UploadRequest& chunk) {
  digest_ = chunk.blob().digest();
  blob_size_ = chunk.blob().size_bytes();
  stored_bytes_ = chunk.offset();
  if (!wire::is_digest(digest_))
    return absl::InvalidArgumentError("the first chunk names no blob by SHA-256 digest");
  if (blob_size_ > wire::kMaxBlobBytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("blob ", digest_, " is larger than ", wire::kMaxBlobBytes, " bytes"));
  }
  if (stored_bytes_ > blob_size_) {
    return absl::InvalidArgumentError(
        absl::StrCat("the upload of ", digest_, " begins at ", stored_bytes_, " of ", blob_size_, " bytes"));
  }
  if (absl::Status status = admit_ ? admit_(chunk) : absl::OkStatus(); !status.ok()) return status;
  // Before anything is made for it; a blob that is there takes none.
  if (absl::Status room = blobs_.check_room(blob_size_ - stored_bytes_);
      !room.ok() && !blobs_.query(digest_).complete)
    return room;
  auto writer = blobs_.write(digest_, chunk.offset());
  if (!writer.ok()) return writer.status();
  writer_ = *std::move(writer);
  return absl::OkStatus();
}

absl::Status BlobUpload::take(const v1::UploadRequest& chunk) {
  if (!verdict_.ok() || whole_) return verdict_;
  verdict_ = [&] {
    if (writer_ == nullptr) {
      if (absl::Status status = begin(chunk); !status.ok()) return status;
    }
    const std::string& data = chunk.data();
    if (data.size() > wire::kBlobChunkBytes) {
      return absl::InvalidArgumentError(
          absl::StrCat("a chunk has ", data.size(), " bytes, more than ", wire::kBlobChunkBytes));
    }
    if (data.size() > blob_size_ - stored_bytes_) {
      return absl::InvalidArgumentError(
          absl::StrCat("blob ", digest_, " is longer than the ", blob_size_, " bytes announced"));
    }
    // Others may have taken the room meanwhile.
    if (absl::Status room = blobs_.check_room(data.size()); !room.ok()) return room;
    if (absl::Status status = writer_->append(data); !status.ok()) return status;
    stored_bytes_ += data.size();
    received_bytes_ += data.size();
    return absl::OkStatus();
  }();
  whole_ = absl::IsAlreadyExists(verdict_);
  if (whole_) verdict_ = absl::OkStatus();
  if (!verdict_.ok() || whole_) writer_.reset();
  return verdict_;
}

absl::Status BlobUpload::finish() {
  if (!verdict_.ok() || whole_) return verdict_;
  if (writer_ == nullptr) return absl::InvalidArgumentError("the upload has no chunk");
  if (stored_bytes_ < blob_size_) {
    return absl::InvalidArgumentError(
        absl::StrCat("blob ", digest_, " ended at ", stored_bytes_, " of ", blob_size_, " bytes"));
  }
  return writer_->finish();
}

}  // namespace tessera::server
