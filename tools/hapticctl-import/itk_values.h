/** @file
 * What an ITK reader holds, as an Image. For the few files that include ITK.
 */
#pragma once

#include <itkImageIOBase.h>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** Reads information and values of the file that `io` was given. Throws ImportError; what ITK throws is put in words.
 */
[[nodiscard]] Image readWith(itk::ImageIOBase& io);

/** Throws ImportError if a NIfTI file has fewer bytes than its values take, or is gzip and damaged. */
void requireWholeNifti(const std::string& path, std::uint64_t values);

/** Without ITK's addresses and class names. */
[[nodiscard]] std::string inWords(const itk::ExceptionObject& error);

}  // namespace hapticctl_import
