/** @file
 * What an ITK reader holds, as an Image. For the few files that include ITK.
 */
#pragma once

#include <itkImageIOBase.h>

#include <functional>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** What else to look at once it is known how many bytes the values take, and before they are read. */
using BeforeValues = std::function<void(std::uint64_t bytes)>;

/** Reads information and values of the file that `io` was given. Throws ImportError; what ITK throws is put in words.
 */
[[nodiscard]] Image readWith(itk::ImageIOBase& io, const BeforeValues& before_values = {});

/**
 * Of a NIfTI file that ITK has read: puts its origin into millimetres where it is in another unit, and adds to its
 * format which of two places it was given where its header names two. Throws ImportError if the file has fewer bytes
 * than its values take, is gzip and damaged or cut short, or has a spacing that is none.
 */
void checkNifti(const std::string& path, Image& image);
/** Of a NIfTI pair the header, whichever of its two files is named; what is no .img stays. */
[[nodiscard]] std::string niftiHeader(const std::string& path);
/** Throws ImportError for a .nii.gz beside whose name stands a .nii of other bytes: ITK would take the values of that.
 */
void requireOwnValues(const std::string& path);
/** Whether it is NIfTI of the second version, which ITK does not read. */
[[nodiscard]] bool isNifti2(const std::string& path);

/** Without ITK's addresses and class names. */
[[nodiscard]] std::string inWords(const itk::ExceptionObject& error);

}  // namespace hapticctl_import
