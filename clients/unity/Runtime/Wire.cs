// Protobuf's wire format (protobuf.dev/programming-guides/encoding), as far as the messages need it.
using System;
using System.Collections.Generic;
using System.IO;
using System.Text;

namespace Styled {

/// <summary>Reads the fields of one message in order: Next, then the call for the field's type, or Skip.
/// Every call throws FormatException if the bytes have another type; none reads beyond the message.
/// Little-endian machines.</summary>
sealed class WireReader {
  const int VarintType = 0, Fixed64Type = 1, BytesType = 2, Fixed32Type = 5;
  static readonly Encoding Utf8 = new UTF8Encoding(false, true);

  readonly byte[] bytes_;
  readonly int end_;
  int at_, type_;

  public int Field { get; private set; }

  public WireReader(byte[] bytes) : this(bytes, 0, bytes.Length) {}

  WireReader(byte[] bytes, int begin, int end) {
    bytes_ = bytes;
    at_ = begin;
    end_ = end;
  }

  /// <summary>Goes to the next field; false at the end.</summary>
  public bool Next() {
    if (at_ == end_) return false;
    ulong key = Varint();
    type_ = (int)(key & 7);
    if (key >> 3 == 0 || key >> 3 > 536870911) throw new FormatException("a field without a number");
    Field = (int)(key >> 3);
    return true;
  }

  public void Skip() {
    if (type_ == VarintType) Varint();
    else if (type_ == Fixed64Type) Advance(8);
    else if (type_ == Fixed32Type) Advance(4);
    else if (type_ == BytesType) Advance(Length());
    else throw new FormatException("an invalid wire type");
  }

  public ulong Number() {
    Expect(VarintType);
    return Varint();
  }

  public ulong Fixed64() {
    Expect(Fixed64Type);
    return BitConverter.ToUInt64(bytes_, Advance(8));
  }

  public float Float() {
    Expect(Fixed32Type);
    return BitConverter.ToSingle(bytes_, Advance(4));
  }

  public string Text() {
    Expect(BytesType);
    int length = Length();
    try {
      return Utf8.GetString(bytes_, Advance(length), length);
    } catch (ArgumentException) {
      throw new FormatException("text that is not UTF-8");
    }
  }

  public byte[] Bytes() {
    Expect(BytesType);
    var value = new byte[Length()];
    Array.Copy(bytes_, Advance(value.Length), value, 0, value.Length);
    return value;
  }

  public WireReader Message() {
    Expect(BytesType);
    int length = Length(), begin = Advance(length);
    return new WireReader(bytes_, begin, begin + length);
  }

  // Repeated numbers are packed, or each is a field.
  public void Floats(List<float> values) {
    if (type_ == Fixed32Type) {
      values.Add(Float());
      return;
    }
    Expect(BytesType);
    int length = Length(), begin = Advance(length);
    if (length % 4 != 0) throw new FormatException("a number is cut short");
    for (int i = begin; i < at_; i += 4) values.Add(BitConverter.ToSingle(bytes_, i));
  }

  public void Numbers(List<uint> values) { Together(value => values.Add((uint)value)); }

  public void SignedNumbers(List<int> values) {
    Together(value => values.Add((int)((uint)value >> 1) ^ -(int)((uint)value & 1)));
  }

  void Together(Action<ulong> add) {
    if (type_ == VarintType) {
      add(Varint());
      return;
    }
    WireReader packed = Message();
    while (packed.at_ < packed.end_) add(packed.Varint());
  }

  ulong Varint() {
    ulong value = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      byte next = bytes_[Advance(1)];
      value |= (ulong)(next & 127) << shift;
      if (next < 128) return value;
    }
    throw new FormatException("a number of more than ten bytes");
  }

  int Length() {
    ulong length = Varint();
    if (length > (ulong)(end_ - at_)) throw new FormatException("a length beyond the end");
    return (int)length;
  }

  // Returns the position of the next `count` bytes.
  int Advance(int count) {
    if (count > end_ - at_) throw new FormatException("cut short");
    at_ += count;
    return at_ - count;
  }

  void Expect(int type) {
    if (type_ != type) throw new FormatException("field " + Field + " is of another type");
  }
}

/// <summary>Writes the fields of one message.</summary>
sealed class WireWriter {
  readonly MemoryStream out_ = new MemoryStream();

  public byte[] Bytes { get { return out_.ToArray(); } }

  public WireWriter Number(int field, ulong value) {
    Varint((ulong)field << 3);
    Varint(value);
    return this;
  }

  public WireWriter Float(int field, float value) {
    Varint((ulong)field << 3 | 5);
    out_.Write(BitConverter.GetBytes(value), 0, 4);
    return this;
  }

  public WireWriter Message(int field, byte[] value) {
    Varint((ulong)field << 3 | 2);
    Varint((ulong)value.Length);
    out_.Write(value, 0, value.Length);
    return this;
  }

  public WireWriter Text(int field, string value) { return Message(field, Encoding.UTF8.GetBytes(value)); }

  void Varint(ulong value) {
    for (; value > 127; value >>= 7) out_.WriteByte((byte)(value & 127 | 128));
    out_.WriteByte((byte)value);
  }
}

}  // namespace Styled
