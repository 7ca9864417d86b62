#!/bin/sh
# run_csharp.sh CLIENT: compiles the C# client in CLIENT as a library, its example, its sample for
# Unity and the conformance test, which reads the goldens here; skipped (77) where Debian's mono-mcs is missing.
set -eu
for program in mcs mono; do
  command -v "$program" >/dev/null || {
    echo "skipped, no $program: apt install mono-mcs mono-runtime"
    exit 77
  }
done
client=$1 here=$(cd "$(dirname "$0")" && pwd)
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
compile="mcs -langversion:7.2 -warnaserror -nologo"
$compile -target:library -out:"$out/Styled.Client.dll" "$client"/Runtime/*.cs
$compile -out:"$out/heads.exe" -r:"$out/Styled.Client.dll" "$client/Console~/Heads.cs"
# Unity's sample against a stand-in of Unity.
$compile -out:"$out/conformance.exe" -r:"$out/Styled.Client.dll" "$client"/Samples~/*/*.cs \
  "$here/FakeUnity.cs" "$here/Conformance.cs"
mono "$out/conformance.exe" "$here"
