#!/bin/sh
# csharp.sh SOURCE LIBRARIES: the C# class and Unity's sample on libstyled, by Mono and a stand-in of Unity; what
# the C example prints is expected. Skipped (77) where Debian's mono-mcs is missing.
set -eu
for program in mcs mono cc; do
  command -v "$program" >/dev/null || {
    echo "skipped, no $program: apt install mono-mcs mono-runtime"
    exit 77
  }
done
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
mcs -langversion:7.2 -warnaserror -nologo -out:"$out/library.exe" "$1"/clients/unity/Runtime/*.cs \
  "$1/clients/unity/Samples~/RestyledAnimator/RestyledAnimator.cs" "$1/tests/conformance/FakeUnity.cs" \
  "$1/tests/unit/library/Library.cs"
cc -I "$1/model/library" "$1/model/library/example.c" -L "$2" -lstyled -lm -o "$out/example"

# Without libstyled there is one exception, which names it; a second one, of a finalizer, would end the program.
cat >"$out/Missing.cs" <<'CODE'
using System;
static class Missing {
  static void Make() { try { new Styled.Network("open"); } catch (DllNotFoundException e) { Console.WriteLine(e.Message); } }
  static void Main() {
    Make();
    GC.Collect();
    GC.WaitForPendingFinalizers();
  }
}
CODE
mcs -langversion:7.2 -warnaserror -nologo -out:"$out/missing.exe" "$1"/clients/unity/Runtime/*.cs \
  "$1/tests/conformance/FakeUnity.cs" "$out/Missing.cs"
LD_LIBRARY_PATH=/nowhere mono "$out/missing.exe" >"$out/missing" 2>&1
grep styled "$out/missing"

export LD_LIBRARY_PATH="$2" STYLED_WEIGHTS="$1/model/weights/open.safetensors"
"$out/example" zombie >"$out/expected"
mono "$out/library.exe" zombie >"$out/found"
diff "$out/expected" "$out/found"
