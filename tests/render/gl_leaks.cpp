// SPDX-License-Identifier: Apache-2.0
// libOSMesa keeps a few hundred bytes of every context for good; the leak checker of the asan preset must not blame us.

#ifdef UWV_SANITIZED
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa\n"; }
#endif
